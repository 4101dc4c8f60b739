"""Send to the line arbiter the predicates that the sensors prove."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Protocol

from end_effector_hal.arbiter.client._sender import PredicateSender
from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.sensing import Predicates, SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.wires import now_us

from ._tool_policy import arbiter_policy

REPEAT_US = 50_000
"""The longest time between two messages to the arbiter, which forgets predicates after 150 ms."""


class Sender(Protocol):
    """A connection that carries predicates to the arbiter."""

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Return whether the arbiter received them."""

    def close(self) -> None:
        """End the connection."""


class PredicatePublisher:
    """Turn frames into predicates and send them to the line arbiter: changes at once, the rest every 50 ms.

    The arbiter receives the changes of a frame before any write that follows from it; repetitions are sent after it, so
    that no line waits for them. A program that processes the frames calls `use`, and `publish` and `repeat` in its own
    turn. Without one, `frame` processes them, and for a link that is slower than 50 ms a thread repeats the predicates
    while the readings are fresh.

    Args:
        description: the tool; its arbiter need not run yet.
        clock: µs.
        sender: to the arbiter; None: over its socket.
        own: True: send the predicates that the arbiter proves itself; False: the others; default: True with a sender.
    """

    def __init__(
        self,
        description: Description,
        clock: Callable[[], int] = now_us,
        sender: Sender | None = None,
        *,
        own: bool | None = None,
    ) -> None:
        self._sender = sender or PredicateSender(socket_path(description))
        self._description = description
        policy = arbiter_policy(description)
        needed = frozenset(need.predicate for needs in policy.needs.values() for need in needs)
        own = sender is not None if own is None else own
        self._needed = needed & policy.proven if own else needed - policy.proven
        self._predicates = Predicates(description, wanted=self._needed)
        self.repeats = bool(self._needed) and carrier_of(description).period_us > REPEAT_US // 2
        """Whether the link is so slow that predicates must be repeated between two frames."""
        self._clock = clock
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._sent: Mapping[str, bool] = {}
        self._due = 0
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start the thread for a slow link."""
        if self.repeats:
            self._thread = threading.Thread(target=self._repeat, name="predicates", daemon=True)
            self._thread.start()

    def use(self, senses: SensorSet) -> None:
        """Take the predicates from the sensors of a program from now on."""
        self._predicates = Predicates(self._description, senses=senses, wanted=self._needed)

    def publish(self, refused: Frame | None = None) -> None:
        """Send the predicates after a frame if they have changed; never blocks.

        Args:
            refused: the frame, if its stamp was refused or the lines are not adopted: it proves nothing, but what
                objects in it counts.
        """
        if refused is not None:
            at, objections = max(self._predicates.at, refused.at), self._predicates.objections(refused)
            if objections and refused.at <= self._clock():
                self._send(objections, at)
            return
        if self._needed:
            at = self._predicates.at
            if (proven := self._predicates.said(at)) and proven != self._sent:
                self._send(proven, at)

    def repeat(self, at: int | None = None) -> None:
        """Send the predicates again if that is due: as they are at ``at`` µs; default: after the newest frame."""
        seen_at = self._predicates.at if at is None else at
        if self._needed and seen_at >= self._due:
            # even if nothing was read yet: else it would be due at once
            self._due = seen_at + REPEAT_US * 4 // 5
            if proven := self._predicates.said(seen_at):
                self._send(proven, seen_at)

    @property
    def repeats_at(self) -> int | None:
        """Time of the next `repeat` that needs no frame, µs; None: the frames come often enough."""
        return self._due if self.repeats else None

    def frame(self, frame: Frame, pass_on: Callable[[Frame], None] = lambda _: None) -> None:
        """Process one frame of the link; never blocks.

        Args:
            frame: as it arrived.
            pass_on: called with the frame after its changes were sent to the arbiter.
        """
        proven: Mapping[str, bool] = {}
        at = frame.at
        if self._needed:
            with self._lock:
                proven = self._predicates.frame(frame, self._clock())
                # the arbiter ignores predicates older than its own: give a late frame the newest time
                at = max(frame.at, self._predicates.at)
                if proven and proven != self._sent:
                    self._send(proven, at)
                    proven = {}
        pass_on(frame)
        if proven and at >= self._due:
            with self._lock:
                self._send(proven, at)

    def close(self) -> None:
        """Stop sending and close the sender."""
        self._ended.set()
        if self._thread and self._thread.ident is not None:
            self._thread.join()
        with self._lock:
            self._sender.close()

    def _repeat(self) -> None:
        while not self._ended.wait(REPEAT_US / 1e6):
            with self._lock:
                at = self._clock()
                proven = self._predicates.advance(at)
                if proven and (proven != self._sent or at >= self._due):
                    self._send(proven, at)

    def _send(self, proven: Mapping[str, bool], at: int) -> None:
        self._due = at + REPEAT_US * 4 // 5
        if self._sender.send(proven, at):
            self._sent = proven
