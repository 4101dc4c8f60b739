"""Messages between the nodes count only with a stamp that is not ahead of now."""

from __future__ import annotations

import logging

from end_effector_hal.signals import StampGate
from end_effector_hal.wires import now_us


class Stamped:
    """Judges the stamps of one kind of message, and logs when it begins to refuse; not thread-safe.

    Args:
        what: the messages, for a sentence; plural.
        log: of the node.
    """

    def __init__(self, what: str, log: logging.Logger) -> None:
        self._gate, self._log = StampGate(what), log

    def counts(self, *stamps: int) -> bool:
        """Whether all stamps of a message (µs, monotonic clock of this machine) may count now."""
        now = now_us()
        before = self._gate.notices(now)
        counts = all(self._gate.passes(stamp, now) for stamp in stamps)
        for text in self._gate.notices(now):
            if text not in before:
                self._log.error("%s", text)
        return counts

    def notices(self, at_us: int) -> tuple[str, ...]:
        """What was refused lately, in words."""
        return self._gate.notices(at_us)
