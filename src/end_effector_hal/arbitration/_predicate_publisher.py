"""The process that reads the sensor link sends what it proves to the line arbiter."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Protocol

from end_effector_hal.arbiter import PredicateSender
from end_effector_hal.codecs import Carrier, carrier_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.sensing import FrameJudge, Predicates
from end_effector_hal.signals import Frame
from end_effector_hal.wires import now_us

from ._policy import arbiter_policy

REPEAT_US = 50_000
"""The arbiter gets them at least so often; it forgets them after 150 ms."""


class Sender(Protocol):
    """Takes what is proven to the arbiter."""

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Whether it got there."""

    def close(self) -> None:
        """End."""


class PredicatePublisher:
    """Frames in, predicates to the line arbiter: on change at once, else every 50 ms.

    Frames are passed on through `frame`: then the arbiter has each before any command that follows
    from it. What is only repeated comes after them: no line waits for it. A link that is slower than that is repeated
    by a thread, for as long as its readings are fresh.

    Args:
        description: the tool; its arbiter need not run yet.
        carrier: of its channels; default: what the description says.
        clock: µs.
        judge: shared with those in this process who get the same frames.
        sender: to the arbiter; None: over its socket.
        own: whether it sends what the arbiter proves by itself, or what it does not; default: where it has a sender.
    """

    def __init__(
        self,
        description: Description,
        carrier: Carrier | None = None,
        clock: Callable[[], int] = now_us,
        judge: FrameJudge | None = None,
        sender: Sender | None = None,
        *,
        own: bool | None = None,
    ) -> None:
        carrier = carrier or carrier_of(description)
        self._sender = sender or PredicateSender(socket_path(description))
        self._predicates = Predicates(description, carrier, judge)
        policy = arbiter_policy(description)
        needed = {need.predicate for needs in policy.needs.values() for need in needs}
        own = sender is not None if own is None else own
        self._needed = needed & policy.proven if own else needed - policy.proven
        self.repeats = bool(self._needed) and carrier.period_us > REPEAT_US // 2
        """Whether its link is so slow that what is proven has to be repeated between two frames."""
        self._clock = clock
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._sent: Mapping[str, bool] = {}
        self._due = 0
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin."""
        if self.repeats:
            self._thread = threading.Thread(target=self._repeat, name="predicates", daemon=True)
            self._thread.start()

    def frame(self, frame: Frame, pass_on: Callable[[Frame], None] = lambda _: None) -> None:
        """One frame of the link; never blocks.

        Args:
            frame: as it came.
            pass_on: called with it once the arbiter was told what it changes.
        """
        proven: Mapping[str, bool] = {}
        at = frame.at
        if self._needed:
            with self._lock:
                proven = self._needed_of(self._predicates.frame(frame, self._clock()))
                # the arbiter ignores what is older than what it knows: a late frame is news all the same
                at = max(frame.at, self._predicates.at)
                if proven and proven != self._sent:
                    self._send(proven, at)
                    proven = {}
        pass_on(frame)
        if proven and at >= self._due:
            with self._lock:
                self._send(proven, at)

    def pass_over(self) -> None:
        """Frames that change nothing have come; see `FrameJudge.pass_over`."""
        with self._lock:
            proven, at = self._needed_of(self._predicates.holding), self._predicates.at
            if proven and at >= self._due:
                self._send(proven, at)

    def repeat(self) -> None:
        """Say again what is still proven; called every `REPEAT_US` where it ``repeats``."""
        with self._lock:
            at = self._clock()
            proven = self._needed_of(self._predicates.advance(at))
            if proven and (proven != self._sent or at >= self._due):
                self._send(proven, at)

    def close(self) -> None:
        """Send nothing any more; the sender ends with it."""
        self._ended.set()
        if self._thread and self._thread.ident is not None:
            self._thread.join()
        with self._lock:
            self._sender.close()

    def _repeat(self) -> None:
        while not self._ended.wait(REPEAT_US / 1e6):
            self.repeat()

    def _needed_of(self, proven: Mapping[str, bool]) -> dict[str, bool]:
        return {name: holds for name, holds in proven.items() if name in self._needed}

    def _send(self, proven: Mapping[str, bool], at: int) -> None:
        if self._sender.send(proven, at):
            self._sent, self._due = proven, at + REPEAT_US * 4 // 5
