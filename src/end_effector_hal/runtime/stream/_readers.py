"""Those who read a stream: how many there may be, how much waits for each, what they may say."""

from __future__ import annotations

import selectors
import socket
from collections.abc import Iterator

from end_effector_hal.wires import Acceptor

from ._protocol import LONGEST

MOST_READERS = 16
MOST_MESSAGES = 100
"""Of one reader in a second: to read them takes time from the program."""
SECOND_US = 1_000_000
MOST_BYTES = 2_000_000
"""What waits for a reader who takes its time; one for whom more would wait is dropped."""


class StreamReader:
    """One connection; nothing here waits.

    Args:
        sock: the connection.
        longest: bytes of a message from it.
    """

    def __init__(self, sock: socket.socket, longest: int = LONGEST) -> None:
        sock.setblocking(False)
        self.sock, self._longest = sock, longest
        self.follows = False
        """It has the state from which the records go on."""
        self.commands_waiting = 0
        self._second = self._messages = 0
        self._out = bytearray()
        self.watched = False
        """It is woken once more can be sent."""
        self._rest = b""

    @property
    def behind(self) -> int:
        """Bytes that wait for it."""
        return len(self._out)

    def put(self, data: bytes) -> bool:
        """Send it as soon as it can be; False: too much waits already."""
        if len(self._out) + len(data) > MOST_BYTES:
            return False
        self._out += data
        return self.send()

    def send(self) -> bool:
        """Send what can be sent now; False: the connection is gone."""
        try:
            while self._out:
                sent = self.sock.send(memoryview(self._out)[:65_536])
                del self._out[:sent]
        except BlockingIOError:
            pass
        except OSError:
            return False
        return True

    def floods(self, messages: int, at: int) -> bool:
        """Whether more came within a second, with these, than anybody has to say."""
        if at - self._second >= SECOND_US:
            self._second, self._messages = at, 0
        self._messages += messages
        return self._messages > MOST_MESSAGES

    def receive(self) -> tuple[list[bytes], bool]:
        """The whole messages that came, and whether the connection goes on; an overlong one ends it."""
        try:
            data = self.sock.recv(4 * self._longest)
        except BlockingIOError:
            return [], True
        except OSError:
            return [], False
        *lines, self._rest = (self._rest + data).split(b"\n")
        return lines, bool(data) and len(self._rest) <= self._longest


class StreamReaders:
    """All of them, registered with a selector, each with itself as its data.

    Args:
        selector: with which they are registered.
        longest: bytes of a message from one.
    """

    def __init__(self, selector: selectors.BaseSelector, longest: int = LONGEST) -> None:
        self._selector, self._longest = selector, longest
        self._open: dict[StreamReader, None] = {}

    def __iter__(self) -> Iterator[StreamReader]:
        return iter(list(self._open))

    def __len__(self) -> int:
        return len(self._open)

    def accept(self, acceptor: Acceptor) -> None:
        """Accept a client that waits.

        Where all places are taken, it gets that of the reader that is furthest behind; where all of them keep up, it is
        closed at once.
        """
        if (sock := acceptor.accept()) is None:
            return
        if len(self._open) >= MOST_READERS:
            last = max(self._open, key=lambda reader: reader.behind)
            if not last.behind:
                sock.close()
                return
            self.drop(last)
        reader = StreamReader(sock, self._longest)
        self._open[reader] = None
        self._selector.register(sock, selectors.EVENT_READ, reader)

    def put(self, reader: StreamReader, data: bytes) -> None:
        """Send it to one; one who does not keep up is dropped."""
        if reader in self._open:
            self._go_on(reader, reader.put(data))

    def send(self, reader: StreamReader) -> None:
        """Send what waits for one."""
        self._go_on(reader, reader.send())

    def drop(self, reader: StreamReader) -> None:
        """End its connection."""
        if self._open.pop(reader, self) is None:
            self._selector.unregister(reader.sock)
            reader.sock.close()

    def _go_on(self, reader: StreamReader, goes_on: bool) -> None:
        if not goes_on:
            self.drop(reader)
            return
        if (is_behind := bool(reader.behind)) is not reader.watched:
            reader.watched = is_behind
            events = selectors.EVENT_READ | (selectors.EVENT_WRITE if is_behind else 0)
            self._selector.modify(reader.sock, events, reader)
