"""The connections of the line arbiter: their limits, their idle time and the order in which they are answered."""

from __future__ import annotations

import selectors
import socket
import struct
from collections import Counter
from operator import attrgetter

from end_effector_hal.arbiter.rules import Session
from end_effector_hal.arbiter.rules._session import process_words
from end_effector_hal.vocabulary import LONGEST_MESSAGE
from end_effector_hal.wires import now_us, program_name
from end_effector_hal.wires.rpc import Listener, Peer, Peers

MOST_STRANGERS = 32
"""Most connections that neither write lines nor send predicates.

The other connections are few: one predicate sender, and at most one writer per line.
"""
IDLE_US = 10_000_000
ACCEPTED = 8
RANK = attrgetter("rank")
MESSAGES = 8
"""Messages per connection and round; a quarter for one that neither writes lines nor sends predicates."""


class Connection(Peer):
    """A connection of one client. A client that does not read its replies counts as dead: replies are not queued.

    Args:
        sock: the accepted socket; `close` closes it.
        at: the time now, µs.
    """

    def __init__(self, sock: socket.socket, at: int) -> None:
        super().__init__(sock, LONGEST_MESSAGE)
        self.pid, self.uid, _ = struct.unpack(
            "3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        )
        self.program = program_name(self.pid) if self.pid else ""
        self.session: Session | None = None
        self.sends_predicates = False
        self.heard_at = at

    @property
    def process(self) -> str:
        """The client's process, in words."""
        return process_words(self.pid, self.program)

    @property
    def rank(self) -> int:
        """The order of answers, lowest first: predicates come before the writes that depend on them."""
        return 0 if self.sends_predicates else 1 if self.session else 2


class Connections(Peers[Connection]):
    """All connections to the socket of the arbiter.

    Args:
        listener: the arbiter's socket.
        selector: reports the connections that have data to read.
    """

    def __init__(self, listener: Listener, selector: selectors.BaseSelector) -> None:
        super().__init__(listener, selector, lambda sock: Connection(sock, now_us()))

    def admit(self) -> list[Connection]:
        """Accept waiting connections; return surplus ones to close: the oldest of the user that has the most."""
        for _ in range(ACCEPTED):
            if self.accept() is None:
                break
        strangers, surplus = [each for each in self._open if each.rank == 2], list[Connection]()
        while len(strangers) > MOST_STRANGERS:
            ((uid, _),) = Counter(each.uid for each in strangers).most_common(1)
            surplus.append(next(each for each in strangers if each.uid == uid))
            strangers.remove(surplus[-1])
        return surplus

    def idle(self, at: int) -> list[Connection]:
        """Return the connections that were silent for too long; those that write lines have a lease instead."""
        return [each for each in self._open if not each.session and at - each.heard_at >= IDLE_US]

    def due(self) -> int | None:
        """Return when the next connection will have been silent for too long, µs; None: there is none."""
        return min((each.heard_at + IDLE_US for each in self._open if not each.session), default=None)
