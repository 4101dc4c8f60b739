"""What an operator must know: sentences that stay until somebody has had the chance to read them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

from end_effector_hal.kinds import AlarmKind
from end_effector_hal.vocabulary import OVER


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

    def of_kind(self, kind: AlarmKind) -> dict[str, Alarm]:
        """Those of a kind, by what each is about."""
        return {who: alarm for (each, who), alarm in self._alarms.items() if each is kind}

    def active(self, kind: AlarmKind) -> bool:
        """Whether there is one of a kind that is not over."""
        return bool(self._alarms) and any(
            alarm.kind is kind and not alarm.over for alarm in self._alarms.values()
        )

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
        self._alarms[kind, who] = replace(known, text=f"{OVER}{text}", over=True)
        self._changed()
        return True

    def forget(self, kind: AlarmKind, who: str) -> None:
        """It is so no longer, and nobody need acknowledge it."""
        if self._alarms.pop((kind, who), None):
            self._changed()

    def acknowledge(self) -> None:
        """Forget what is over."""
        self._remove(key for key, alarm in self._alarms.items() if alarm.over)

    def clear(self) -> None:
        """Forget what was about a held part: nothing is held any more. What a device says of itself stays."""
        self._remove(key for key in self._alarms if key[0] is not AlarmKind.DEVICE)

    def _remove(self, keys: Iterable[tuple[AlarmKind, str]]) -> None:
        for key in list(keys):
            del self._alarms[key]
        self._changed()

    def _changed(self) -> None:
        self.texts = tuple([alarm.text for alarm in self._alarms.values()])
