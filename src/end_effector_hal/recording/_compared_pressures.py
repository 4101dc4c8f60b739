"""Find where the pressures of two recordings differ."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from math import inf
from typing import Any

from ._pressures import PressuresLog


@dataclass(frozen=True)
class RunDifference:
    """A difference, with its line of the figure and its time.

    Args:
        line: ``end_effector``, ``command``, an actuator, ``tool_changer``, ``alarms``, or the channel of a pressure.
        text: the difference in words.
        first_s, second_s: time, seconds since the start of each recording; None: absent from that recording.
    """

    line: str
    text: str
    first_s: float | None
    second_s: float | None

    def as_json(self) -> dict[str, Any]:
        """Return the fields as JSON."""
        return asdict(self)


def count_differences(number: int) -> str:
    """Return the number in words: ``no difference``, ``1 difference``, ``2 differences``."""
    return f"{number or 'no'} difference{'s' * (number > 1)}"


LEAST_APART_S = 0.5
"""Gap below which two stretches are reported as one, s."""
STEADY_S = 1.5
"""Longest gap between two samples of a pressure that is interpolated, s; a steady pressure is written twice
a second.
"""


@dataclass
class Shifts:
    """The offsets from times of the first recording to times of the second, each with its start time."""

    start_s: float
    _from: list[float] = field(default_factory=list)
    _by: list[float] = field(default_factory=list)

    @property
    def latest_s(self) -> float:
        return self._by[-1] if self._by else self.start_s

    def add(self, first_s: float, by_s: float) -> None:
        """Add an offset that is valid from ``first_s`` on, which must be later than the start of all
        earlier offsets.
        """
        self._from.append(first_s)
        self._by.append(by_s)

    def second_s(self, first_s: float) -> float:
        index = bisect_right(self._from, first_s)
        return first_s + (self._by[index - 1] if index else self.start_s)

    def first_s(self, second_s: float) -> float | None:
        """Return the time in the first recording; None: only the second recording has this time."""
        starts = [-inf, *self._from, inf]
        for start, end, by in zip(starts, starts[1:], [self.start_s, *self._by], strict=False):
            if start <= second_s - by < end:
                return second_s - by
        return None


@dataclass
class _Stretch:
    """An interval in which a pressure differs, on the first recording's clock; ``kpa``: the largest difference,
    signed.
    """

    start_s: float
    end_s: float
    kpa: float


def pressure_differences(
    first: PressuresLog | None,
    second: PressuresLog | None,
    shifts: Shifts,
    within_s: float,
    within_kpa: float,
) -> Iterator[RunDifference]:
    """Yield a difference for each stretch of each channel that both recordings have.

    A channel of only one recording is reported without a time.
    """
    names = [] if first is None else first.channels
    others = [] if second is None else second.channels
    for name in dict.fromkeys((*names, *others)):
        if first is None or second is None or name not in names or name not in others:
            which = "first" if name in names else "second"
            yield RunDifference(name, f"only the {which} recording has this pressure", None, None)
            continue
        for each in _stretches(_Curve.of(first, name), _Curve.of(second, name), shifts, within_s, within_kpa):
            side = "higher" if each.kpa > 0 else "lower"
            length = each.end_s - each.start_s
            unit = first.units.get(name, "kPa")
            text = f"up to {abs(each.kpa):.1f} {unit} {side} in the second, for {length:.2f} s"
            yield RunDifference(name, text, each.start_s, shifts.second_s(each.start_s))


@dataclass(frozen=True)
class _Curve:
    """The valid values of one channel, and their times."""

    times_s: Sequence[float]
    kpa: Sequence[float]

    @classmethod
    def of(cls, log: PressuresLog, channel: str) -> _Curve:
        valid = [
            (at, value)
            for at, value in zip(log.times_s, log.curve(channel), strict=True)
            if value is not None
        ]
        return cls([at for at, _ in valid], [value for _, value in valid])

    def near(self, at_s: float, within_s: float) -> tuple[float, float] | None:
        """Return the least and the greatest value within ``within_s`` of ``at_s``; None: there is no value."""
        times, kpa = self.times_s, self.kpa
        low, high = bisect_left(times, at_s - within_s), bisect_right(times, at_s + within_s)
        values = list(kpa[low:high])
        for edge, index in ((at_s - within_s, low), (at_s + within_s, high)):
            if 0 < index < len(times) and times[index] - times[index - 1] <= STEADY_S:
                share = (edge - times[index - 1]) / ((times[index] - times[index - 1]) or 1.0)
                values.append(kpa[index - 1] + min(max(share, 0.0), 1.0) * (kpa[index] - kpa[index - 1]))
        return (min(values), max(values)) if values else None


def _stretches(
    first: _Curve, second: _Curve, shifts: Shifts, within_s: float, within_kpa: float
) -> list[_Stretch]:
    points = [
        (at, -_beyond(value, second.near(shifts.second_s(at), within_s)))
        for at, value in zip(first.times_s, first.kpa, strict=True)
    ]
    for at, value in zip(second.times_s, second.kpa, strict=True):
        if (back := shifts.first_s(at)) is not None:
            points.append((back, _beyond(value, first.near(back, within_s))))
    found: list[_Stretch] = []
    for at, apart in sorted(points):
        if abs(apart) <= within_kpa:
            continue
        last = found[-1] if found else None
        if last is not None and at - last.end_s < LEAST_APART_S and (last.kpa > 0) == (apart > 0):
            last.end_s, last.kpa = at, max(last.kpa, apart, key=abs)
        else:
            found.append(_Stretch(at, at, apart))
    return found


def _beyond(value: float, others: tuple[float, float] | None) -> float:
    """Return how far a value is outside a range, kPa; 0 within it, or if the other recording has no value there."""
    if others is None:
        return 0.0
    low, high = others
    return value - high if value > high else value - low if value < low else 0.0
