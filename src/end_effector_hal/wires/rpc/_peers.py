"""Non-blocking connections, and the set of all connections of a listener."""

from __future__ import annotations

import selectors
import socket
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

from ._listener import Listener


class Peer:
    """One non-blocking connection, of a server or of a client.

    Args:
        sock: the connected socket; `close` closes it.
        longest: longest line that the other end may send, bytes.
        backlog: most bytes that may wait to be sent.
    """

    def __init__(self, sock: socket.socket, longest: int, backlog: int = 0) -> None:
        sock.setblocking(False)
        self.sock, self._longest, self._backlog = sock, longest, backlog
        self.closed = False
        """Whether this end is closed."""
        self.ended = False
        """Whether the other end is closed; lines that it sent before can still be fetched."""
        self.watched = False
        """Whether the selector also reports when more data can be sent."""
        self._rest, self._out = b"", bytearray()

    @property
    def waits(self) -> bool:
        """Whether a complete line was received and is not fetched yet."""
        return b"\n" in self._rest

    @property
    def overlong(self) -> bool:
        """Whether the other end sent a line that is too long."""
        return not self.waits and len(self._rest) > self._longest

    @property
    def behind(self) -> int:
        """Number of bytes that wait to be sent."""
        return len(self._out)

    def receive(self) -> None:
        """Read the available data; read nothing while lines wait, so that a flood fills the sender's buffers."""
        if b"\n" in self._rest or self.ended:
            return
        try:
            data = self.sock.recv(self._longest)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self.ended, self._rest = not data, self._rest + data

    def next_line(self) -> bytes | None:
        """Return the next line and remove it; None: there is no complete line."""
        line, newline, rest = self._rest.partition(b"\n")
        if not newline:
            return None
        self._rest = rest
        return line

    def put(self, data: bytes) -> bool:
        """Send what fits now and keep the rest; return False if the connection is lost or the backlog exceeded."""
        if not self._out:
            try:
                sent = self.sock.send(data)
            except BlockingIOError:
                sent = 0
            except OSError:
                return False
            if sent == len(data):
                return True
            data = data[sent:]
        self._out += data
        return self.send() and len(self._out) <= self._backlog

    def send(self) -> bool:
        """Send waiting data as far as possible now; return False if the connection is lost."""
        try:
            while self._out:
                sent = self.sock.send(memoryview(self._out)[:65_536])
                del self._out[:sent]
        except BlockingIOError:
            pass
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Close this end."""
        self.closed = True
        self.sock.close()


P = TypeVar("P", bound=Peer)


class Peers(Generic[P]):
    """All connections of a listener, registered with a selector; the data of each registration is the connection.

    Args:
        listener: registered too, with None as its data; `close` closes it.
        selector: the caller's selector.
        make: makes a connection from a socket; if it raises OSError, the client is refused.
    """

    def __init__(
        self, listener: Listener, selector: selectors.BaseSelector, make: Callable[[socket.socket], P]
    ) -> None:
        self._listener, self._selector, self._make = listener, selector, make
        self._open: dict[P, None] = {}  # in the order in which they came
        selector.register(listener, selectors.EVENT_READ)

    def __iter__(self) -> Iterator[P]:
        return iter(list(self._open))

    def __len__(self) -> int:
        return len(self._open)

    def accept(self) -> P | None:
        """Accept a client and return its connection; None: no client waits, or it was refused."""
        if (sock := self._listener.accept()) is None:
            return None
        try:
            peer = self._make(sock)
            self._selector.register(sock, selectors.EVENT_READ, peer)
        except OSError as error:
            self._listener.report(error)
            sock.close()
            return None
        self._open[peer] = None
        return peer

    def put(self, peer: P, data: bytes) -> bool:
        """Send data to a connection that may have ended; return False if it was dropped: lost, or too slow."""
        return peer not in self._open or self._watch(peer, peer.put(data))

    def send(self, peer: P) -> bool:
        """Send the waiting data of a connection; returns like `put`."""
        return peer not in self._open or self._watch(peer, peer.send())

    def drop(self, peer: P) -> None:
        """Close a connection."""
        if self._open.pop(peer, self) is None:
            self._selector.unregister(peer.sock)
            peer.close()

    def close(self) -> None:
        """Close all connections and the listener."""
        for peer in self:
            self.drop(peer)
        self._listener.close()

    def _watch(self, peer: P, goes_on: bool) -> bool:
        """Drop a failed connection; otherwise let the selector report when more can be sent, if data waits."""
        if not goes_on:
            self.drop(peer)
            return False
        if (behind := bool(peer.behind)) is not peer.watched:
            peer.watched = behind
            events = selectors.EVENT_READ | (selectors.EVENT_WRITE if behind else 0)
            self._selector.modify(peer.sock, events, peer)
        return True
