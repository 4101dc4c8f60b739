"""Send to the line arbiter the predicates that the sensors prove."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Protocol

from end_effector_hal.arbiter.client import PredicateSender
from end_effector_hal.codecs import Carrier, carrier_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.sensing import FrameJudge, Predicates
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

    `frame` passes every frame on after the arbiter has received the changes, so that the arbiter has them before any
    command that follows from the frame. Repetitions are sent after the frame, so that no line waits for them. For a
    link that is slower than 50 ms a thread repeats the predicates while the readings are fresh.

    Args:
        description: the tool; its arbiter need not run yet.
        carrier: the carrier of its channels; default: the one in the description.
        clock: µs.
        judge: shared with the other readers of the same frames in this process.
        sender: to the arbiter; None: over its socket.
        own: True: send the predicates that the arbiter proves itself; False: the others; default: True with a sender.
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
                proven = self._needed_of(self._predicates.frame(frame, self._clock()))
                # the arbiter ignores predicates older than its own: give a late frame the newest time
                at = max(frame.at, self._predicates.at)
                if proven and proven != self._sent:
                    self._send(proven, at)
                    proven = {}
        pass_on(frame)
        if proven and at >= self._due:
            with self._lock:
                self._send(proven, at)

    def pass_over(self) -> None:
        """Repeat the predicates after frames without a change; see `FrameJudge.pass_over`."""
        with self._lock:
            proven, at = self._needed_of(self._predicates.holding), self._predicates.at
            if proven and at >= self._due:
                self._send(proven, at)

    def repeat(self) -> None:
        """Repeat the predicates that still hold; called every `REPEAT_US` if ``repeats``."""
        with self._lock:
            at = self._clock()
            proven = self._needed_of(self._predicates.advance(at))
            if proven and (proven != self._sent or at >= self._due):
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
            self.repeat()

    def _needed_of(self, proven: Mapping[str, bool]) -> dict[str, bool]:
        return {name: holds for name, holds in proven.items() if name in self._needed}

    def _send(self, proven: Mapping[str, bool], at: int) -> None:
        if self._sender.send(proven, at):
            self._sent, self._due = proven, at + REPEAT_US * 4 // 5
