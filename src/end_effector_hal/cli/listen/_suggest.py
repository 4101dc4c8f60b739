"""Proposes thresholds of a vacuum from its levels in a recorded grip and drop: at rest, and while a part was held."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import click

from end_effector_hal.cli._output import print_line
from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import kind_of
from end_effector_hal.recording import PressuresLog, RunFile, StatesLog, read_pressures, read_states
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import EndEffectorState

SHARES = {
    "confirmed_kpa": 0.75,
    "lost_kpa": 0.65,
    "lost_at_once_kpa": 0.35,
    "gone_kpa": 0.15,
    "secure_kpa": 0.9,
    "secure_hysteresis_kpa": 0.15,
}
"""Position of each threshold as a share of the way from the level at rest to the level when held; that of the
hysteresis is a width.
"""
LEAST_KPA = 15.0
"""Smallest difference between rest and held, kPa; with less, noise would decide."""
SETTLED, UNTIL = 0.5, 0.95
"""Part of each span that is used, as shares: earlier the level is still changing, and later it may have dropped
already.
"""
LEAST_SAMPLES = 3


@dataclass(frozen=True)
class SeenLevel:
    """Lowest and highest level in the settled part of some spans, kPa below ambient."""

    low: float
    high: float
    spans: int
    seconds: float

    def __str__(self) -> str:
        times = "" if self.spans == 1 else f" in {self.spans} spans"
        low, high = (round(each, 1) + 0.0 for each in (self.low, self.high))  # no -0.0
        return f"{low:.1f} to {high:.1f} kPa for {self.seconds:.1f} s{times}"


@dataclass(frozen=True)
class Suggestion:
    """The levels of one actuator, and the thresholds between them."""

    actuator: str
    rest: SeenLevel
    held: SeenLevel

    @property
    def thresholds(self) -> dict[str, float]:
        """The proposed thresholds by their key."""
        way = self.held.low - self.rest.high
        return {
            key: round(way * share + (0.0 if "hysteresis" in key else max(self.rest.high, 0.0)), 1)
            for key, share in SHARES.items()
        }

    def why(self, key: str) -> str:
        """Return the reason for one of the thresholds."""
        share = f"{SHARES[key]:.0%} of the way"
        if "hysteresis" in key:
            return f"{share} from rest to held: no longer secure above lost_kpa"
        return f"{share} from at most {round(self.rest.high, 1) + 0.0:.1f} at rest to at least {self.held.low:.1f} held"


def suggestions(tool: Description, states: StatesLog, pressures: PressuresLog) -> Iterator[Suggestion | str]:
    """Yield a suggestion for each actuator with thresholds of a vacuum, or a sentence if the recording does not allow
    one.
    """
    if not states.rows or not pressures.samples:
        yield "The recording is empty."
        return
    end_s, switched = pressures.times_s[-1], _by_switches(tool)
    for name, actuator in tool.ordered:
        if not kind_of(actuator).below_ambient or any(not hasattr(actuator, key) for key in SHARES):
            none = f"for a {actuator.kind} no thresholds are proposed"
            yield f"{name}: {'switches have no thresholds' if name in switched else none}."
            continue
        if name not in states.actuators or actuator.channel not in pressures.channels:
            yield f"{name}: the recording has no pressure {actuator.channel!r} of it."
            continue
        at = states.actuators.index(name)
        held = _level(
            pressures, actuator.channel, _spans(states, at, EndEffectorState.GRIPPED, end_s, active=True)
        )
        rest = _level(
            pressures, actuator.channel, _spans(states, at, EndEffectorState.STAND_BY, end_s, active=False)
        )
        if held is None or rest is None:
            lacking = [
                word for word, level in (("held (GRIPPED)", held), ("at rest (STAND_BY)", rest)) if not level
            ]
            missed = f"the recording does not show it {' nor '.join(lacking)} for a while"
            yield f"{name}: {missed}: record a grip and a drop."
        elif held.low - rest.high < LEAST_KPA:
            yield f"{name}: at rest {rest}, held {held}: closer than {LEAST_KPA:g} kPa, no threshold fits between."
        else:
            yield Suggestion(name, rest, held)


def _by_switches(tool: Description) -> frozenset[str]:
    """Return the actuators that no pressure confirms."""
    carried = carrier_of(tool).channels
    return frozenset(
        name for name, actuator in tool.ordered if carried.get(actuator.channel) is not Kind.PRESSURE
    )


def _spans(
    log: StatesLog, actuator: int, state: EndEffectorState, end_s: float, *, active: bool
) -> list[tuple[float, float]]:
    """Return the times in which the tool was in a state while the actuator was active or inactive."""
    found: list[tuple[float, float]] = []
    last = replace(log.rows[-1], time_s=max(end_s, log.rows[-1].time_s))
    for row, after in pairwise([*log.rows, last]):
        if row.end_effector is state and (row.actuators[actuator] == 2) is active:
            if found and found[-1][1] == row.time_s:
                found[-1] = (found[-1][0], after.time_s)
            else:
                found.append((row.time_s, after.time_s))
    return found


def _level(log: PressuresLog, channel: str, spans: Sequence[tuple[float, float]]) -> SeenLevel | None:
    curve = log.curve(channel)
    seen: list[float] = []
    used, seconds = 0, 0.0
    for start, end in spans:
        settled, until = (start + share * (end - start) for share in (SETTLED, UNTIL))
        inside = [
            -kpa
            for time_s, kpa in zip(log.times_s, curve, strict=True)
            if settled <= time_s < until and kpa is not None
        ]
        if inside:
            used, seconds, seen = used + 1, seconds + until - settled, seen + inside
    return SeenLevel(min(seen), max(seen), used, seconds) if len(seen) >= LEAST_SAMPLES else None


def print_suggestions(tool: Description, folder: Path, *, as_json: bool) -> None:
    """Read a recording and print the suggested thresholds.

    Raises:
        UsageError: there is no recording, or it allows no suggestion for any actuator.
    """
    if len(_by_switches(tool)) == len(tool.actuators):
        raise UsageError(
            "Switches have no thresholds: this tool has no pressure that proves an actuator.", todo=""
        )
    for name in (RunFile.STATES, RunFile.PRESSURES):
        if not (folder / name).is_file():
            todo = "Record a grip and a drop: `eehal run TOOL --record FOLDER`."
            raise UsageError(f"There is no {name} here.", where=str(folder), todo=todo)
    found = list(
        suggestions(tool, read_states(folder / RunFile.STATES), read_pressures(folder / RunFile.PRESSURES))
    )
    good = [each for each in found if isinstance(each, Suggestion)]
    refused = [each for each in found if isinstance(each, str)]
    if not good:
        raise UsageError(
            "The recording does not suffice to suggest thresholds.", where=str(folder), todo=" ".join(refused)
        )
    if as_json:
        told = {
            each.actuator: {
                key: {"value": value, "why": each.why(key)} for key, value in each.thresholds.items()
            }
            for each in good
        }
        print_line(suggestions=told, refused=refused)
        return
    click.echo("actuators:")
    for each in good:
        click.echo(f"  {each.actuator}:  # at rest {each.rest}; held {each.held}")
        for key, value in each.thresholds.items():
            click.echo(f"    {key}: {value:g}".ljust(34) + f"# {each.why(key)}")
    for sentence in refused:
        click.echo(sentence, err=True)
