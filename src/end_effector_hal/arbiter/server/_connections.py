"""All connections of the arbiter: how many there may be, how long they may be silent, the order of their answers."""

from __future__ import annotations

import selectors
import socket
import struct
from collections import Counter

from end_effector_hal.arbiter.rules import Session, process_words
from end_effector_hal.vocabulary import LONGEST_MESSAGE
from end_effector_hal.wires import now_us, program_name
from end_effector_hal.wires.rpc import Listener, Peer, Peers

MOST_STRANGERS = 32
"""Connections that neither write lines nor send predicates; there is one sender, and at most one writer per line."""
IDLE_US = 10_000_000
ACCEPTED = 8
MESSAGES = 8
"""In one round, from one connection; a quarter of that from one that neither writes nor sends predicates."""


class Connection(Peer):
    """A client without a backlog: one that does not read its replies is treated as dead.

    Args:
        sock: accepted; it is closed by `close`.
        at: now, µs.
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
        """The process at the other end, for people."""
        return process_words(self.pid, self.program)

    @property
    def rank(self) -> int:
        """The order of answers: what the sensors prove was sent before any write that follows from it."""
        return 0 if self.sends_predicates else 1 if self.session else 2


class Connections(Peers[Connection]):
    """Those of the arbiter's socket.

    Args:
        listener: the arbiter's socket.
        selector: reports those that have something to read.
    """

    def __init__(self, listener: Listener, selector: selectors.BaseSelector) -> None:
        super().__init__(listener, selector, lambda sock: Connection(sock, now_us()))

    def admit(self) -> list[Connection]:
        """Accept those that wait; returns connections to be closed for them: the oldest of the user that has most."""
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
        """Those that were silent for too long; connections that write lines have a lease instead."""
        return [each for each in self._open if not each.session and at - each.heard_at >= IDLE_US]

    def due(self) -> int | None:
        """When the next one will have been silent for too long."""
        return min((each.heard_at + IDLE_US for each in self._open if not each.session), default=None)

    def round(self, ready: set[Connection]) -> list[Connection]:
        """Those that have messages, in the order in which they are answered."""
        waiting = [each for each in self._open if each in ready or each.waits]
        return sorted(waiting, key=lambda each: each.rank)

    @property
    def wait(self) -> bool:
        """Whether messages were received that are not fetched yet."""
        return any(each.waits for each in self._open)
