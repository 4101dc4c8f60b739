"""What an operator must know: sentences that stay until somebody has had the chance to read them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from end_effector_hal.kinds import AlarmKind


@dataclass(frozen=True, slots=True)
class Alarm:
    """One finding; ``over``: it is so no longer, and is shown until it is acknowledged."""

    kind: AlarmKind
    at: int
    """µs when it began."""
    text: str
    over: bool = False


class AlarmLog:
    """Alarms in the order in which they began; each is kept until it is over *and* acknowledged."""

    MEMORY: ClassVar = {"listed": list[tuple[str, Alarm]]}

    def __init__(self) -> None:
        self._alarms: dict[tuple[AlarmKind, str], Alarm] = {}
        self.texts: tuple[str, ...] = ()
        """All of them, in words."""

    @property
    def listed(self) -> list[tuple[str, Alarm]]:
        """All of them, each with what it is about, in their order."""
        return [(who, alarm) for (_, who), alarm in self._alarms.items()]

    @listed.setter
    def listed(self, alarms: list[tuple[str, Alarm]]) -> None:
        self._alarms = {(alarm.kind, who): alarm for who, alarm in alarms}
        self._changed()

    def active(self, kind: AlarmKind) -> bool:
        """Whether there is one of a kind that is not over."""
        return any(alarm.kind is kind and not alarm.over for alarm in self._alarms.values())

    def raise_(self, kind: AlarmKind, who: str, text: str, at: int) -> bool:
        """It is so now; False when that was known. The text is that of its beginning: it does not flicker."""
        known = self._alarms.get((kind, who))
        if known is not None and not known.over:
            return False
        self._alarms[kind, who] = Alarm(kind, known.at if known else at, text)
        self._changed()
        return True

    def end(self, kind: AlarmKind, who: str, text: str) -> bool:
        """It is so no longer; False when that was known."""
        known = self._alarms.get((kind, who))
        if known is None or known.over:
            return False
        self._alarms[kind, who] = replace(known, text=f"Over: {text}", over=True)
        self._changed()
        return True

    def acknowledge(self) -> None:
        """Forget what is over."""
        self._alarms = {key: alarm for key, alarm in self._alarms.items() if not alarm.over}
        self._changed()

    def clear(self) -> None:
        """Forget everything: what it was about has ended."""
        self._alarms.clear()
        self._changed()

    def _changed(self) -> None:
        self.texts = tuple([alarm.text for alarm in self._alarms.values()])
