"""The log of alarms, which keeps every alarm until an operator could read it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from end_effector_hal.vocabulary import Alarm

DEVICE_ALARMS = ("device.error", "device.warning")
FAILED = "kind.failed"


class AlarmLog:
    """Alarms in the order in which they began; each stays until it is over *and* acknowledged."""

    MEMORY: ClassVar = {"listed": tuple[Alarm, ...]}

    def __init__(self) -> None:
        self.listed: tuple[Alarm, ...] = ()

    def of_id(self, *ids: str) -> dict[str, Alarm]:
        """Return the alarms with one of these ids, by the thing they are about."""
        return {each.about: each for each in self.listed if each.id in ids}

    def active(self, id_: str) -> bool:
        """Return whether an alarm with this id is listed and not over."""
        return bool(self.listed) and any(each.id == id_ and not each.over for each in self.listed)

    def raise_(self, alarm: Alarm) -> bool:
        """Begin an alarm; return False if it is active already: it keeps the values of its beginning."""
        known = self._known(alarm.id, alarm.about)
        if known is None:
            self.listed = (*self.listed, alarm)
        elif known.over:
            self._replace(known, replace(alarm, since=known.since))
        return known is None or known.over

    def end(self, id_: str, about: str, values: Mapping[str, str | int | float] | None = None) -> bool:
        """Mark an alarm as over; return False if it is not active.

        ``values`` are the values for the text of the ended alarm; None: its values stay as they are.
        """
        known = self._known(id_, about)
        if known is None or known.over:
            return False
        self._replace(known, replace(known, values=known.values if values is None else values, over=True))
        return True

    def forget(self, id_: str, about: str) -> None:
        """Remove an alarm that nobody needs to acknowledge."""
        self.listed = tuple([each for each in self.listed if each.key != (id_, about)])

    def acknowledge(self) -> None:
        """Remove all alarms that are over."""
        self.listed = tuple([each for each in self.listed if not each.over])

    def clear(self) -> None:
        """Remove the alarms about the part, because nothing is held now. Faults of devices and plug-ins stay."""
        self.listed = tuple([each for each in self.listed if each.id in (*DEVICE_ALARMS, FAILED)])

    def _known(self, id_: str, about: str) -> Alarm | None:
        for each in self.listed:
            if each.id == id_ and each.about == about:
                return each
        return None

    def _replace(self, old: Alarm, new: Alarm) -> None:
        self.listed = tuple([new if each is old else each for each in self.listed])
