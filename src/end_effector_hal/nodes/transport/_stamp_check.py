"""Messages between the nodes count only with a stamp that is not ahead of now."""

from __future__ import annotations

import logging

from end_effector_hal.signals import StampGate
from end_effector_hal.vocabulary import Alarm
from end_effector_hal.wires import now_us


class StampCheck:
    """Checks the stamps of one kind of message, and logs when it begins to refuse; not thread-safe.

    Args:
        what: the messages, for a sentence; plural.
        log: of the node.
    """

    def __init__(self, what: str, log: logging.Logger) -> None:
        self._gate, self._log = StampGate(what), log

    def accepts(self, *stamps: int) -> bool:
        """Whether no stamp of a message (µs, monotonic clock of this machine) is ahead of now."""
        now = now_us()
        before = self._gate.notices(now)
        accepted = all(self._gate.passes(stamp, now) for stamp in stamps)
        for alarm in self._gate.notices(now):
            if alarm not in before:
                self._log.error("%s", alarm)
        return accepted

    def notices(self, at_us: int) -> tuple[Alarm, ...]:
        """The alarm of what was refused lately."""
        return self._gate.notices(at_us)
