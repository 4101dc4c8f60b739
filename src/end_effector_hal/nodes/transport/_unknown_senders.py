"""Drop and count messages and calls of nodes that the interface table does not name, and raise an alarm about them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from end_effector_hal.vocabulary import Alarm

ALARM_S = 10.0
"""Time for which an alarm stays after the last dropped message, s."""
LONGEST_NAME = 80


@dataclass(slots=True)
class _Dropped:
    count: int
    at_us: int
    alarm: str


class UnknownSenders:
    """Counts the dropped messages and calls of each topic or service; thread-safe.

    The alarm names only the first unknown node, so that any number of names causes one alarm.

    Args:
        report: called with each new alarm.
        clock: returns the monotonic time, µs.
    """

    def __init__(self, report: Callable[[str], None], clock: Callable[[], int]) -> None:
        self._report, self._clock = report, clock
        self._lock = threading.Lock()
        self._dropped: dict[str, _Dropped] = {}

    def drop(self, what: str, caller: str, known: str, also: str = "") -> str:
        """Count a dropped message or call, and return the alarm.

        Args:
            what: resolved name of a topic or service of this tool.
            caller: the name that the sender states; any text.
            known: the node whose messages are accepted there, in words.
            also: a sentence for the end of the alarm.
        """
        now = self._clock()
        with self._lock:
            dropped = self._dropped.get(what) or _Dropped(0, 0, "")
            fresh = not self._is_recent(dropped, now)
            if fresh:
                who = ascii(caller[:LONGEST_NAME])[1:-1] or "a node without a name"
                alarm = f"{what}: messages of {who} are ignored; only {known} may send there."
                dropped.alarm = f"{alarm} {also}".rstrip()
            dropped.count, dropped.at_us = dropped.count + 1, now
            self._dropped[what] = dropped
        if fresh:
            self._report(dropped.alarm)
        return dropped.alarm

    def alarms(self) -> tuple[Alarm, ...]:
        """Return an alarm for each topic or service with a dropped message or call in the last 10 s."""
        now = self._clock()
        with self._lock:
            recent = [(what, each) for what, each in self._dropped.items() if self._is_recent(each, now)]
        return tuple(Alarm("node.unknown_sender", what, {"text": each.alarm}) for what, each in recent)

    def counts(self) -> dict[str, int]:
        """Return the number of messages and calls dropped since the start, by topic or service."""
        with self._lock:
            return {what: each.count for what, each in self._dropped.items()}

    @staticmethod
    def _is_recent(dropped: _Dropped, now: int) -> bool:
        return dropped.count > 0 and now - dropped.at_us <= ALARM_S * 1e6
