"""The grips of many recordings of one tool: their outcomes by day, and how times and margins change over time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime, timedelta
from itertools import groupby
from math import inf
from pathlib import Path
from statistics import median
from typing import Any

from end_effector_hal.description import Description, content_hash
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.page.view import margin_kpa
from end_effector_hal.recording import (
    COUNTEREXAMPLE,
    MODEL_RUN,
    Grip,
    GripDecision,
    RunFile,
    RunInfo,
    StatesLog,
    last_pressures,
    read_run,
    read_states,
    read_story,
)
from end_effector_hal.vocabulary import EndEffectorState, display_name, printable

from ._folder import BROKEN, MOST_INFO_BYTES, changed_at, is_small

MOST_RECORDINGS, MOST_GRIPS = 2_000, 200_000
"""Largest numbers of recordings and of grips that are read; the newest recordings come first."""
MOST_BYTES = 130_000_000
"""Largest table of states or events, bytes: two segments."""
NO_GRIP = "No recording has a grip of this tool."
MOST_COLUMNS = 60
"""Largest number of columns of a plot."""
DECIDED = (GripDecision.GRIPPED, GripDecision.ABORTED)
"""The outcomes that say something about the tool; any other was decided by a person or a program."""


@dataclass(frozen=True, slots=True)
class PastGrip:
    """A recorded grip.

    Attributes:
        at: when it began, local time.
        part: name of the part; empty: it has none.
        decision: its outcome.
        first_attempt: whether it succeeded, with each actuator confirmed on its first attempt.
        confirm_s: time from the activation to the confirmation of the confirmed attempt, s, by actuator.
        margin_kpa: margin at the end of the hold, kPa, by actuator.
    """

    at: datetime
    part: str
    decision: GripDecision
    first_attempt: bool
    confirm_s: Mapping[str, float]
    margin_kpa: Mapping[str, float]


@dataclass(frozen=True)
class PastTrend:
    """A value of an actuator over time, for a plot.

    Attributes:
        title: what it is, with its unit.
        column: what a column of the plot is.
        values: one for each column, in order of time; a margin may be below 0.
        top: the value at the top of the plot, above 0.
        top_label: the same as text.
        ends: the first, the last and the worst value in words.
    """

    title: str
    column: str
    values: list[float]
    top: float
    top_label: str
    ends: str


@dataclass
class ToolHistory:
    """The grips of a tool in order of time.

    Attributes:
        tool: the tool.
        recordings: the recordings whose grips are listed.
        grips: the grips of all recordings.
        notes: sentences about recordings that were left out, or of which something is missing.
    """

    tool: Description
    recordings: list[str] = field(default_factory=list)
    grips: list[PastGrip] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON, the same for the command and the page."""
        return {
            "tool": self.tool.name, "grips": len(self.grips), "said": self.said, "days": list(self.rows()),
            "trends": [asdict(each) for each in self.trends()], "recordings": self.recordings, "notes": self.notes,
        }  # fmt: skip

    @property
    def said(self) -> str:
        """How many grips there are, and of which days."""
        if not self.grips:
            return NO_GRIP
        first, last = (each.at.date().isoformat() for each in (self.grips[0], self.grips[-1]))
        grips, recordings = _counted(self.grips, "grip"), _counted(self.recordings, "recording")
        return f"{self.tool.name}: {grips} in {recordings}, {first} to {last}"

    def trends(self) -> Iterator[PastTrend]:
        """Yield the times to confirm and the margins of each actuator that has some."""
        for name, actuator in self.tool.ordered:
            label, grips = display_name(name), self.grips
            times = [grip.confirm_s[name] for grip in grips if name in grip.confirm_s]
            margins = [grip.margin_kpa[name] for grip in grips if name in grip.margin_kpa]
            if times:
                title = f"{label}: time to confirm, s (time-out {actuator.timeout_s:g} s)"
                yield _trend(title, times, 2, max(times))
            if margins:
                yield _trend(f"{label}: margin at the end of the hold, kPa", margins, 1, min(margins))

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield a row for each day and part, as JSON: outcomes, and times and margins by actuator."""

        def key(grip: PastGrip) -> tuple[str, str]:
            return grip.at.date().isoformat(), grip.part

        for (day, part), found in groupby(sorted(self.grips, key=key), key):
            grips = list(found)
            names = dict.fromkeys(name for grip in grips for name in (*grip.confirm_s, *grip.margin_kpa))
            yield {
                "day": day,
                "part": part,
                "grips": len(grips),
                "outcomes": dict(Counter(str(grip.decision) for grip in grips)),
                "first_attempt_rate": first_attempt_rate(grips),
                "actuators": {
                    name: {
                        "confirm_s": _spread([g.confirm_s[name] for g in grips if name in g.confirm_s]),
                        "margin_kpa": _spread([g.margin_kpa[name] for g in grips if name in g.margin_kpa]),
                    }
                    for name in names
                },
            }


def _trend(title: str, values: list[float], decimals: int, worst: float) -> PastTrend:
    each = -(-len(values) // MOST_COLUMNS)
    medians = [median(values[start : start + each]) for start in range(0, len(values), each)]
    top = max(*medians, 0.0, 10.0**-decimals)
    ends = f"first {medians[0]:.{decimals}f}, last {medians[-1]:.{decimals}f}, worst {worst:.{decimals}f}"
    column = f"one column: {'1 grip' if each == 1 else f'the median of {each} grips'}"
    return PastTrend(title, column, medians, top, f"{top:.{decimals}f}", ends)


def _counted(found: Sequence[object], noun: str) -> str:
    return f"{len(found)} {noun}{'' if len(found) == 1 else 's'}"


def first_attempt_rate(grips: Sequence[PastGrip]) -> float | None:
    """Return the share of the decided grips that succeeded on first attempts; None: none was decided."""
    decided = [grip.first_attempt for grip in grips if grip.decision in DECIDED]
    return round(sum(decided) / len(decided), 4) if decided else None


def _spread(values: list[float]) -> dict[str, float] | None:
    if not values:
        return None
    return {"median": round(median(values), 3), "least": round(min(values), 3), "most": round(max(values), 3)}


def read_history(
    tool: Description, folders: Iterable[Path], part: str = "", progress: Callable[[str], object] = str
) -> ToolHistory:
    """Read the tables of recordings; one that cannot be used is noted and left out.

    Simulated runs count only if no other run has a grip. Margins are measured against the thresholds of ``tool``.

    Args:
        tool: the tool; recordings of other tools are left out.
        folders: the folders of the recordings.
        part: read the grips of this part alone; empty: of all parts.
        progress: called with a text before each recording is read.
    """
    real, simulated, others = ToolHistory(tool), ToolHistory(tool), set[str]()
    own = content_hash(tool)
    newest = sorted(folders, key=lambda path: (changed_at(path) or 0.0, path), reverse=True)
    notes = [f"{len(newest)} recordings are too many: the newest {MOST_RECORDINGS} are read."]
    notes = notes if len(newest) > MOST_RECORDINGS else []
    for path in newest[:MOST_RECORDINGS]:
        progress(f"Reading {path}")
        try:
            info = read_run(path) if is_small(path / RunFile.INFO, MOST_INFO_BYTES) else RunInfo()
            into = simulated if info.is_simulated else real
            into.grips += [
                grip for grip in _grips(tool, path, info, into.notes) if not part or grip.part == part
            ]
        except BROKEN as error:
            what = str(error)
            if isinstance(error, UsageError):  # the place within the folder
                what = ": ".join(filter(None, (Path(error.where).name, error.what)))
            notes.append(f"{printable(str(path))} is left out: {printable(what)}")
            continue
        into.recordings.append(str(path))
        if info.hash != own:
            others.add(info.hash or "unknown")
        if len(real.grips) + len(simulated.grips) > MOST_GRIPS:
            notes.append(f"More than {MOST_GRIPS} grips: recordings older than {path} are left out.")
            break
    found = real if real.grips else simulated
    if real.grips and simulated.grips:
        notes.append(f"{len(simulated.recordings)} simulated recordings are left out.")
    elif simulated.grips:
        notes.append("All of these grips were simulated.")
    if others and found.grips:
        notes.append(
            f"Recorded with other descriptions than {own}, too: {printable(', '.join(sorted(others)[:5]))}. Margins "
            "are measured against today's thresholds."
        )
    found.notes = [*notes, *found.notes]
    found.grips.sort(key=lambda grip: grip.at)
    return found


def _grips(tool: Description, folder: Path, info: RunInfo, notes: list[str]) -> Iterator[PastGrip]:
    """Yield the grips of one recording; raise UsageError if it is damaged or not of this tool."""
    if info.scenario == COUNTEREXAMPLE or info.scenario.startswith(MODEL_RUN):
        raise UsageError("it is a run of the model.")
    if info.description not in ("", tool.name):
        raise UsageError(f"it is of the tool {info.description}.")
    for name in (RunFile.STATES, RunFile.EVENTS):
        if sum(path.stat().st_size for path in folder.glob(f"{Path(name).stem}*.csv")) > MOST_BYTES:
            raise UsageError(f"{name} has more than {MOST_BYTES / 1e6:.0f} MB.")
    kinds = {name: actuator.kind for name, actuator in tool.ordered}
    log = read_states(folder / RunFile.STATES)
    if log.actuators != tool.sequence or (info.actuators and dict(info.actuators) != kinds):
        raise UsageError(f"it is of a tool with other actuators ({', '.join(log.actuators)}).")
    if log.events is None:
        raise UsageError("it has no events.csv.")
    try:
        started = datetime.fromisoformat(info.started).astimezone()
    except (ValueError, OverflowError, OSError):
        raise UsageError("its run.json does not say when it began.") from None
    grips = read_story(log, info).grips
    gripped = [grip for grip in grips if grip.decision is GripDecision.GRIPPED]
    holds = list(_holds(log, gripped))
    margins = iter(_margins(tool, folder, [grip.part for grip in gripped], holds, notes))
    for grip in grips:
        margin = next(margins) if grip.decision is GripDecision.GRIPPED else {}
        at = started + timedelta(seconds=grip.start_s)
        yield PastGrip(at, grip.part, grip.decision, grip.first_attempt, grip.confirm_s, margin)


def _holds(log: StatesLog, gripped: Iterable[Grip]) -> Iterator[tuple[float, float]]:
    """Yield when each hold began, and when the state was no longer GRIPPED (infinite: it was to the end)."""
    rows, index, holding = log.rows, 0, (EndEffectorState.GRIPPING, EndEffectorState.GRIPPED)
    for grip in gripped:
        begin = grip.decided_s or 0.0
        while index < len(rows) and (rows[index].time_s < begin or rows[index].end_effector in holding):
            index += 1
        yield begin, rows[index].time_s if index < len(rows) else inf


def _margins(
    tool: Description,
    folder: Path,
    parts: Sequence[str],
    holds: Sequence[tuple[float, float]],
    notes: list[str],
) -> list[dict[str, float]]:
    """Return the margins at the end of the hold of each part, by actuator; empty where no pressure is known."""
    path = folder / RunFile.PRESSURES
    try:
        found = last_pressures(path, holds)
    except ReportedError as error:
        if path.exists():
            notes.append(f"{printable(str(path))}: margins are not known. {printable(str(error))}")
        return [{} for _ in holds]
    return [_margins_of(tool, part, kpa) for part, kpa in zip(parts, found, strict=True)]


def _margins_of(tool: Description, part: str, kpa: Mapping[str, float]) -> dict[str, float]:
    if tool.part_number(part) is None:
        return {}  # today's tool does not name it
    supply_kpa = kpa.get(tool.supply.channel)
    supply_pa = None if supply_kpa is None else supply_kpa * 1000
    found: dict[str, float] = {}
    for used, (name, actuator) in zip(tool.uses(part), tool.for_part(part).ordered, strict=True):
        value = kpa.get(actuator.channel)
        margin = None if value is None else margin_kpa(actuator, value * 1000, tool.supply, supply_pa)
        if used and margin is not None:
            found[name] = margin
    return found
