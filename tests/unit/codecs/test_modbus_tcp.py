"""Modbus TCP as a wire of Modbus RTU: headers and numbers of transactions."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from end_effector_hal.codecs.modbus import TcpFrames
from end_effector_lab.testbench.devices import sealed

READ = sealed(bytes.fromhex("110300 6B 0003"))
ANSWER = bytes.fromhex("1103 06 AE41 5652 4340")


def framed(transaction: int, body: bytes, *, protocol: int = 0, size: int | None = None) -> bytes:
    length = len(body) if size is None else size
    return b"".join(each.to_bytes(2, "big") for each in (transaction, protocol, length)) + body


def test_a_request_has_the_header_of_the_standard_and_no_crc() -> None:
    frames = TcpFrames()
    assert frames.request(READ) == bytes.fromhex("0001 0000 0006 1103 006B 0003")
    assert frames.request(READ)[:2] == b"\0\2"


def test_an_answer_comes_as_a_frame_of_rtu_however_it_is_cut() -> None:
    for cut in range(1, len(ANSWER) + 6):
        frames = TcpFrames()
        frames.request(READ)
        data = framed(1, ANSWER)
        assert frames.feed(data[:cut]) + frames.feed(data[cut:]) == sealed(ANSWER)


@pytest.mark.parametrize(
    "arriving",
    [
        pytest.param(lambda: framed(1, ANSWER), id="late: of the request before"),
        pytest.param(lambda: framed(3, ANSWER), id="never asked"),
        pytest.param(lambda: framed(0, ANSWER), id="zero"),
    ],
)
def test_an_answer_of_another_transaction_is_dropped(arriving: Callable[[], bytes]) -> None:
    frames = TcpFrames()
    frames.request(READ)
    frames.request(READ)
    other = bytes.fromhex("1103 06 0000 0000 0000")
    assert frames.feed(arriving()) == b""
    assert frames.feed(framed(2, other)) == sealed(other)


def test_an_answer_that_comes_twice_counts_once() -> None:
    frames = TcpFrames()
    frames.request(READ)
    assert frames.feed(framed(1, ANSWER) * 2) == sealed(ANSWER)
    assert frames.feed(framed(1, ANSWER)) == b""


@pytest.mark.parametrize(
    "data",
    [
        pytest.param(b"HTTP/1.1 400 Bad Request\r\n", id="another server"),
        pytest.param(framed(1, ANSWER, protocol=1), id="another protocol"),
        pytest.param(framed(1, b"", size=0xFFFF), id="a huge length"),
        pytest.param(framed(1, b"", size=255), id="longer than the standard allows"),
        pytest.param(framed(1, b"", size=2), id="no function"),
        pytest.param(sealed(ANSWER) * 3, id="frames of RTU"),
    ],
)
def test_what_is_no_modbus_tcp_ends_the_connection(data: bytes) -> None:
    frames = TcpFrames()
    frames.request(READ)
    with pytest.raises(ValueError, match="does not speak Modbus TCP"):
        frames.feed(data)


def test_the_numbers_of_transactions_begin_again() -> None:
    frames = TcpFrames()
    numbers = [int.from_bytes(frames.request(READ)[:2], "big") for _ in range(65_537)]
    assert numbers[-3:] == [65_535, 1, 2]


def test_unfinished_data_are_bounded() -> None:
    frames = TcpFrames()
    frames.request(READ)
    for _ in range(1000):
        frames.feed(framed(7, ANSWER)[:-1])
        frames.feed(ANSWER[-1:])
        assert len(frames._rest) < 300
