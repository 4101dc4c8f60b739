"""Computes the evidence of an actuator from conditions over channels."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.kinds.stanza import Condition, EvidenceConditions
from end_effector_hal.signals import PART, ChannelReadings, Streak
from end_effector_hal.vocabulary import Evidence

from ._judge import ConditionJudge

FAULT_US = 500_000
"""Time after which contradicting sensors count as broken, µs; the same as for a tool changer (IL-04)."""


class ConditionDetector:
    """Judges an actuator as confirmed, gone, partial or unknown, as the conditions define.

    A confirmed actuator stays confirmed until ``lost`` holds. After an interruption it is confirmed again when it has
    not been lost for as long as ``confirmed`` requires: a short silence must not look like a loss.

    Attributes:
        level: the evidence.
        empty: whether the actuator has gripped nothing.
        contradicts: whether its sensors contradict each other now, so that nothing is proven.
        broken: whether they have contradicted each other for half a second.
    """

    MEMORY: ClassVar = {
        "_judges": PART,
        "_contradiction": PART,
        "_held": bool,
        "level": Evidence,
        "empty": bool,
        "contradicts": bool,
        "broken": bool,
    }

    def __init__(self, conditions: EvidenceConditions) -> None:
        self._judges = {name: ConditionJudge(each) for name, each in _conditions(conditions).items()}
        self._contradiction = Streak()
        self._held = False
        self.level = Evidence.UNKNOWN
        self.empty = self.contradicts = self.broken = False

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence after one more sample at ``at`` µs."""
        shown = {name: judge.sample(readings, at) for name, judge in self._judges.items()}
        self.contradicts = shown["contradiction"] is True
        self._contradiction.take(self.contradicts, at)
        self.broken = self._contradiction.lasted(at, FAULT_US)
        self.empty = shown.get("empty") is True and not self.contradicts
        if self.contradicts:
            for name, judge in self._judges.items():
                if name != "contradiction":
                    judge.forget()
            self.level = Evidence.UNKNOWN
        else:
            self.level = self._level(shown["confirmed"], shown["gone"], shown["lost"], shown["again"])
        return self.level

    def settles(self, at: int) -> bool:
        """Return whether the sensors contradict each other or recently did.

        A short contradiction is normal: two switches do not change at the same time.
        """
        return self.contradicts or self._contradiction.began_within(at, FAULT_US)

    def _level(
        self, confirmed: bool | None, gone: bool | None, lost: bool | None, again: bool | None
    ) -> Evidence:
        if self._held and (lost is True or (gone is True and confirmed is not True)):
            self._held = False
        if self._held:
            if lost is None:
                return Evidence.UNKNOWN
            proven = self.level is Evidence.CONFIRMED or again is True or confirmed is True
            return Evidence.CONFIRMED if proven else Evidence.UNKNOWN
        if confirmed is True and lost is False:
            self._held = True
            return Evidence.CONFIRMED
        if gone is True:
            return Evidence.GONE
        unknown = confirmed is None or gone is None or (confirmed is True and lost is None)
        return Evidence.UNKNOWN if unknown else Evidence.PARTIAL


def _conditions(given: EvidenceConditions) -> dict[str, Condition]:
    """Return all conditions that a detector evaluates, defaults included."""
    confirmed = given.confirmed.at_once
    lost = given.lost or _not(confirmed)
    asked = {
        "confirmed": given.confirmed,
        "gone": given.gone,
        "lost": lost,
        "again": _not(lost.at_once).model_copy(update=_longest(given.confirmed)),
        "contradiction": _contradiction(given),
    }
    return asked if given.empty is None else {**asked, "empty": given.empty}


def _contradiction(given: EvidenceConditions) -> Condition:
    both = _joined(all=(given.confirmed.at_once, given.gone.at_once))
    fault, there, gone = given.fault, given.confirmed.asked, given.gone.asked
    if fault is None and there is not None and gone is not None:
        fault = _joined(all=(there, gone))
    return both if fault is None else _joined(any=(fault, both))


def _not(condition: Condition) -> Condition:
    return _joined(not_=condition)


def _joined(**parts: object) -> Condition:
    """Return a condition of validated parts; it may be nested one level deeper than a written one."""
    return Condition(on="it").model_copy(update={"on": None, **parts})


def _longest(condition: Condition) -> dict[str, int]:
    inside = [_longest(each) for each in condition.parts]
    inside.append({"for_ms": condition.for_ms, "samples": condition.samples})
    return {key: max(each[key] for each in inside) for key in ("for_ms", "samples")}
