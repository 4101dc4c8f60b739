"""Evidence of an actuator by its own conditions over channels: judged on readings, and described in words.

A condition is true, false or unknown (None).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import count
from math import inf
from typing import Any, ClassVar, Protocol

from end_effector_hal.kinds.stanza import Condition, EvidenceConditions, named
from end_effector_hal.signals import (
    GAUGE_PRESSURE,
    NESTED,
    ChannelReadings,
    Measure,
    MeasuredReadings,
    Streak,
)
from end_effector_hal.vocabulary import Evidence

_Asked = Callable[[ChannelReadings, int, "ConditionJudge"], bool | None]
"""A condition as a function of the readings, their time (µs), and the judge with the streaks of its parts."""


class ConditionJudge:
    """Judges one condition and remembers how long each of its lasting parts has held.

    A sample counts for a lasting part if the newest frame contained a channel of that part. Time alone makes readings
    stale and so unknown; it never makes a condition hold.
    """

    MEMORY: ClassVar = {"streaks": NESTED, "seen": list[int]}

    def __init__(self, condition: Condition) -> None:
        numbers = count()
        self._asked = _compiled(condition, numbers)
        self.streaks = [Streak() for _ in range(next(numbers))]
        self.seen = [0] * len(self.streaks)

    def sample(self, readings: ChannelReadings, at: int) -> bool | None:
        """Return whether the condition holds at ``at`` µs; None: unknown."""
        return self._asked(readings, at, self)

    def forget(self) -> None:
        """Reset the duration of every part."""
        for streak in self.streaks:
            streak.samples = 0


def _compiled(this: Condition, numbers: Iterator[int]) -> _Asked:
    """Return a condition as a function of a sample, because it never changes and each frame evaluates it."""
    at_once = _joined(this, [_compiled(each, numbers) for each in this.parts]) if this.parts else _read(this)
    if this.for_ms == 0 and this.samples == 1:
        return at_once
    index, samples, us, channels = next(numbers), this.samples, this.for_ms * 1000, this.channels

    def lasts(readings: ChannelReadings, at: int, judge: ConditionJudge) -> bool | None:
        value, streak = at_once(readings, at, judge), judge.streaks[index]
        if not readings.arrived.isdisjoint(channels):
            judge.seen[index] = at
        elif value is not None:
            return streak.samples >= samples and streak.lasted(judge.seen[index], us)
        if value is True:
            streak.take(True, at)
            return streak.samples >= samples and streak.lasted(at, us)
        streak.samples = 0
        return value

    return lasts


def _joined(this: Condition, parts: list[_Asked]) -> _Asked:
    """Return a function that combines the parts by Kleene's three-valued logic.

    It evaluates every part, even if one alone decides, because each part has its own memory.
    """
    if this.not_ is not None:
        (part,) = parts
        return lambda *sample: None if (value := part(*sample)) is None else not value
    decides = not this.all  # true decides `any`, false decides `all`

    def joined(readings: ChannelReadings, at: int, judge: ConditionJudge) -> bool | None:
        values = [part(readings, at, judge) for part in parts]
        return decides if decides in values else None if None in values else not decides

    return joined


def _read(this: Condition) -> _Asked:
    channel = this.on or this.channel or ""
    if this.on is not None:
        return lambda readings, *_: None if (value := readings.fresh.get(channel)) is None else bool(value)
    low, high = this.span
    closed = this.between_kpa is not None or this.between is not None

    def passes(readings: ChannelReadings, at: int, judge: ConditionJudge) -> bool | None:
        value = readings.fresh.get(channel)
        if value is None or isinstance(value, bool):
            return None  # a bit has no thresholds
        measured = value / 1000  # kPa of Pa, or units of thousandths
        return low <= measured <= high if closed else low < measured < high

    return passes


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
        "_judges": NESTED,
        "_contradiction": NESTED,
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
        if self.contradicts:
            self._contradiction.take(True, at)
            self.broken = self._contradiction.lasted(at, FAULT_US)
        else:
            self._contradiction.samples, self.broken = 0, False
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
    both = _made(all=(given.confirmed.at_once, given.gone.at_once))
    fault, there, gone = given.fault, given.confirmed.asked, given.gone.asked
    if fault is None and there is not None and gone is not None:
        fault = _made(all=(there, gone))
    return both if fault is None else _made(any=(fault, both))


def _not(condition: Condition) -> Condition:
    return _made(not_=condition)


def _made(**parts: object) -> Condition:
    """Return a condition of validated parts; it may be nested one level deeper than a written one."""
    return Condition(on="it").model_copy(update={"on": None, **parts})


def _longest(condition: Condition) -> dict[str, int]:
    inside = [_longest(each) for each in condition.parts]
    inside.append({"for_ms": condition.for_ms, "samples": condition.samples})
    return {key: max(each[key] for each in inside) for key in ("for_ms", "samples")}


class _PartSwitches(Protocol):
    """A stanza with a switch that a part turns on, and optionally a switch that is on when the part is gone.

    Attributes:
        part_bit: on: confirmed; off: lost, and also released if nothing else proves a release.
        gone_bit: on, with part_bit off: released; both on: a contradiction.
        confirmed_ms, lost_ms, gone_ms: how long each state must last.
    """

    @property
    def part_bit(self) -> str | None: ...

    @property
    def gone_bit(self) -> str | None: ...

    @property
    def confirmed_ms(self) -> int: ...

    @property
    def lost_ms(self) -> int: ...

    @property
    def gone_ms(self) -> int: ...


def part_conditions(switches: _PartSwitches) -> EvidenceConditions | None:
    """Return the conditions over the part's switches; None: no switch detects a part."""
    part, gone = named(switches.part_bit), named(switches.gone_bit)
    if part is None:
        return None
    there: dict[str, Any] = {"on": part}
    away: dict[str, Any] = {"not": there} if gone is None else {"all": [{"on": gone}, {"not": there}]}
    return EvidenceConditions.model_validate(
        {
            "confirmed": {**there, "for_ms": switches.confirmed_ms},
            "lost": {"not": there, "for_ms": switches.lost_ms},
            "gone": {**away, "for_ms": switches.gone_ms},
        }
    )


def shown(channels: Iterable[str], readings: ChannelReadings, at: int) -> str:
    """Return the readings at ``at`` µs in words, such as ``closed is off, cup is at -12.3 kPa``."""
    measures = readings.measures if isinstance(readings, MeasuredReadings) else {}
    return ", ".join(
        f"{channel} {_state(readings.get(channel, at), measures.get(channel, GAUGE_PRESSURE))}"
        for channel in channels
    )


def _state(value: int | bool | None, measure: Measure) -> str:
    if value is None:
        return "has no valid reading"
    if isinstance(value, bool):
        return "is on" if value else "is off"
    return f"is at {measure.text(value)}"


def asked(condition: Condition) -> str:
    """Return what a condition requires, such as ``cup less than 10 kPa, and part off``."""
    if condition.not_ is not None:
        inside = asked(condition.not_)
        return f"{condition.not_.on} off" if condition.not_.on else f"not ({inside})"
    if condition.parts:
        return (", and " if condition.all else ", or ").join(map(asked, condition.parts))
    if condition.on is not None:
        return f"{condition.on} on"
    low, high = condition.span
    unit = " kPa" if (condition.below_kpa, condition.above_kpa, condition.between_kpa) != (None,) * 3 else ""
    limits = (
        f"less than {high:g}"
        if low == -inf
        else f"more than {low:g}"
        if high == inf
        else f"{low:g} to {high:g}"
    )
    return f"{condition.channel} {limits}{unit}"
