"""Messages to one subscriber: at once where it keeps up, whole and in order where it does not."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator

import pytest

pytest.importorskip("rospy")

from end_effector_hal.ros1.connections._direct_send import DirectConnection

PATIENCE_S = 30.0


class Transport:
    """What rospy has of a connection."""

    def __init__(self, sock: socket.socket) -> None:
        self.socket, self.done = sock, False
        self.stat_bytes = self.stat_num_msg = 0
        self.threads: set[str] = set()

    def set_cleanup_callback(self, callback: Callable[[object], None]) -> None:
        self.cleanup = callback

    def write_data(self, data: bytes) -> None:
        self.threads.add(threading.current_thread().name)
        self.socket.sendall(data)


@pytest.fixture
def pair() -> Iterator[tuple[Transport, socket.socket]]:
    ours, theirs = socket.socketpair()
    theirs.settimeout(PATIENCE_S)
    transport = Transport(ours)
    yield transport, theirs
    theirs.close()
    transport.done = True
    transport.cleanup(transport)
    ours.close()


def message(number: int, size: int = 20_000) -> bytes:
    return number.to_bytes(4, "big") * (size // 4)


def received(theirs: socket.socket, count: int, size: int = 20_000) -> list[bytes]:
    data = b""
    while len(data) < count * size:
        data += theirs.recv(count * size - len(data))
    assert len(data) == count * size
    return [data[i : i + size] for i in range(0, len(data), size)]


def test_who_keeps_up_has_it_at_once_and_no_thread_was_asked(pair: tuple[Transport, socket.socket]) -> None:
    transport, theirs = pair
    connection = DirectConnection(transport, 10)
    for number in range(5):
        connection.write_data(message(number))
        theirs.setblocking(False)
        assert theirs.recv(20_000) == message(number)
    assert transport.threads == set()
    assert transport.stat_num_msg == 5


def test_who_does_not_keep_up_has_everything_later_in_order(pair: tuple[Transport, socket.socket]) -> None:
    transport, theirs = pair
    connection = DirectConnection(transport, 0)
    for number in range(100):
        connection.write_data(message(number))
    assert received(theirs, 100) == [message(number) for number in range(100)]
    assert transport.threads, "the socket holds less than that"


def test_of_what_waits_too_long_the_oldest_is_dropped_and_no_message_is_torn(
    pair: tuple[Transport, socket.socket],
) -> None:
    transport, theirs = pair
    connection = DirectConnection(transport, 3)
    for number in range(200):
        connection.write_data(message(number))
    numbers: list[int] = []
    while not numbers or numbers[-1] != 199:
        (whole,) = received(theirs, 1)
        numbers.append(int.from_bytes(whole[:4], "big"))
        assert whole == message(numbers[-1])
    assert numbers == sorted(set(numbers))
    assert numbers[-3:] == [197, 198, 199]
    assert len(numbers) < 200


def test_a_subscriber_that_has_gone_is_told_as_rospy_does(pair: tuple[Transport, socket.socket]) -> None:
    transport, theirs = pair
    connection = DirectConnection(transport, 10)
    theirs.close()
    failed = threading.Event()
    for _ in range(int(PATIENCE_S * 100)):
        try:
            connection.write_data(b"x" * 100)
        except OSError:
            failed.set()
            break
        threading.Event().wait(0.01)
    assert failed.is_set()
