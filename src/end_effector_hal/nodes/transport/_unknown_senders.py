"""Messages and calls of nodes that the table does not name: dropped, counted, and reported by an alarm."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from end_effector_hal.vocabulary import Alarm

ALARM_S = 10.0
"""How long an alarm stays after the last message that was dropped."""
LONGEST_NAME = 80


@dataclass(slots=True)
class _Dropped:
    count: int
    at_us: int
    alarm: str


class UnknownSenders:
    """Counts what was dropped on each topic or service; thread-safe.

    The alarm names the node that was seen first: however many names follow, it stays one alarm.

    Args:
        report: called with each new alarm.
        clock: microseconds, monotonic.
    """

    def __init__(self, report: Callable[[str], None], clock: Callable[[], int]) -> None:
        self._report, self._clock = report, clock
        self._lock = threading.Lock()
        self._dropped: dict[str, _Dropped] = {}

    def drop(self, what: str, caller: str, known: str, also: str = "") -> str:
        """Count one message or call; returns the alarm.

        Args:
            what: resolved name of a topic or service of this tool.
            caller: the name that the sender gives; any text.
            known: the node whose messages count there, in words.
            also: a sentence for the end of the alarm.
        """
        now = self._clock()
        with self._lock:
            dropped = self._dropped.get(what) or _Dropped(0, 0, "")
            fresh = not self._is_recent(dropped, now)
            if fresh:
                who = ascii(caller[:LONGEST_NAME])[1:-1] or "a node without a name"
                alarm = f"{what}: what {who} sends does not count, only {known} has a say there."
                dropped.alarm = f"{alarm} {also}".rstrip()
            dropped.count, dropped.at_us = dropped.count + 1, now
            self._dropped[what] = dropped
        if fresh:
            self._report(dropped.alarm)
        return dropped.alarm

    def alarms(self) -> tuple[Alarm, ...]:
        """One for each topic or service where something was dropped in the last 10 s."""
        now = self._clock()
        with self._lock:
            recent = [(what, each) for what, each in self._dropped.items() if self._is_recent(each, now)]
        return tuple(Alarm("node.unknown_sender", what, {"text": each.alarm}) for what, each in recent)

    def counts(self) -> dict[str, int]:
        """Messages and calls that were dropped since the start, by topic or service."""
        with self._lock:
            return {what: each.count for what, each in self._dropped.items()}

    @staticmethod
    def _is_recent(dropped: _Dropped, now: int) -> bool:
        return dropped.count > 0 and now - dropped.at_us <= ALARM_S * 1e6
