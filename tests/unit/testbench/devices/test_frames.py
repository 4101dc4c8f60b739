"""How a device finds the requests in the bytes of a line, and which frames it ignores."""

from __future__ import annotations

import pytest

from end_effector_lab.testbench.devices import FrameReader, read_request, sealed

READ = sealed(bytes.fromhex("09 04 07D0 0003"))
WRITE = sealed(bytes.fromhex("09 10 03E8 0003 06 0900 00FF FFFF"))
BOTH = sealed(bytes.fromhex("09 17 07D0 0001 03E8 0001 02 0900"))
UNKNOWN = sealed(bytes.fromhex("09 2B 0E 01 00"))


def test_the_bytes_of_the_maker() -> None:
    assert READ.hex().upper() == "090407D00003B1CE"
    assert WRITE.hex().upper() == "091003E8000306090000FFFFFF4229"


@pytest.mark.parametrize("frame", [READ, WRITE, BOTH])
def test_a_frame_comes_at_once_in_pieces_or_with_the_next_one(frame: bytes) -> None:
    reader = FrameReader(115_200)
    assert reader.feed(frame, 0) == [frame]
    assert reader.feed(frame + READ, 10_000) == [frame, READ]
    assert reader.feed(frame[:5], 20_000) == []
    assert reader.feed(frame[5:], 21_000) == [frame]


def test_silence_ends_a_frame() -> None:
    reader = FrameReader(115_200)
    reader.feed(WRITE[:9], 0)
    assert reader.feed(READ, 1_751) == [READ]
    slow = FrameReader(9_600)
    slow.feed(READ[:4], 0)
    assert slow.feed(READ[4:], 4_000) == [READ]


def test_a_wrong_crc_is_ignored_with_what_follows_at_once() -> None:
    reader = FrameReader(115_200)
    damaged = READ[:-1] + bytes([READ[-1] ^ 1])
    assert reader.feed(damaged + READ, 0) == []
    assert reader.feed(READ, 5_000) == [READ]


def test_an_unknown_function_ends_with_what_came() -> None:
    assert FrameReader(115_200).feed(UNKNOWN, 0) == [UNKNOWN]


@pytest.mark.parametrize("size", range(1, len(WRITE)))
def test_no_beginning_of_a_frame_is_a_request(size: int) -> None:
    assert read_request(WRITE[:size]) is None
    assert FrameReader(115_200).feed(WRITE[:size], 0) == []
