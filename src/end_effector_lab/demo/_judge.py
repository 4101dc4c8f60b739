"""Judge whether a recording matches its scenario, and agrees with the wires, the answers and the automata."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from pathlib import Path
from statistics import median

from end_effector_hal.control import EventKind
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.recording import AttemptOutcome, Grip, RunInfo, StatesLog, Story, read_story
from end_effector_hal.verification.replay import Review, SegmentEnd, load_trace, review, traces_of
from end_effector_hal.vocabulary import Command, EndEffectorState, TableState
from end_effector_hal.wires.lines import ChipLog
from end_effector_hal.wires.lines import Edge as LineEdge
from end_effector_lab.virtual import Edge, Switching, switchings

from ._report import Finding, Measure, Report
from ._scenario import DemoScenario


def judge(
    scenario: DemoScenario,
    description: Description,
    log: StatesLog,
    info: RunInfo | None = None,
    edges: Sequence[LineEdge] | None = None,
) -> Report:
    """Return the report on one recording.

    Args:
        scenario: the scenario with its expected story.
        description: the tool with the nominal times.
        log: the recording.
        info: the run.json of the recording.
        edges: the edges written to the lines; None: unknown.
    """
    story = read_story(log, info)
    expected = scenario.expected
    attempts = dict(story.grips[0].attempts_by_actuator) if len(story.grips) == 1 else {}
    states = _shown((row.end_effector for row in log.rows), EndEffectorState.OFF)
    commands = _shown((row.command for row in log.rows), Command.NONE)
    return Report(
        scenario=scenario,
        verdict=story.verdict,
        attempts=attempts,
        measures=tuple(measures(description, log, story, expected.slow_release)),
        findings=(
            _start(log),
            _equal("states", _names(expected.states), _names(states)),
            _equal("commands", _names(expected.commands), _names(commands)),
            _equal("attempts", _count(expected.attempts), _count(attempts)),
            _equal("time-outs", _count(expected.timeouts), _count(_timed_out(story))),
            _order(description, story),
            _pending(log),
            _unwound(description, story),
            _left_active(log),
            *([on_the_wires(description, log, edges)] if edges is not None else []),
        ),
    )


def _equal(what: str, expected: str, found: str) -> Finding:
    return Finding(what, expected, found, expected == found)


def _start(log: StatesLog) -> Finding:
    first = log.rows[0] if log.rows else None
    at_rest = first is not None and first.end_effector in (EndEffectorState.OFF, EndEffectorState.STAND_BY)
    ok = first is not None and at_rest and not any(first.actuators) and first.command is Command.NONE
    return Finding("start", "at rest", first.end_effector.name if first else "nothing recorded", ok)


def _shown(column: Iterable[TableState], idle: TableState) -> list[TableState]:
    """Return the values of a column in order, without ``idle`` and repetitions."""
    return [value for value, _ in groupby(value for value in column if value is not idle)]


def _names(values: Iterable[TableState]) -> str:
    return ", ".join(value.name for value in values) or "none"


def _count(numbers: Mapping[str, int]) -> str:
    return ", ".join(f"{name} {number}" for name, number in numbers.items()) or "none"


def _timed_out(story: Story) -> dict[str, int]:
    names = [attempt.actuator for attempt in story.timeouts]
    return {name: names.count(name) for name in dict.fromkeys(names)}


def _order(description: Description, story: Story) -> Finding:
    """Check that an actuator is activated only after the previous one was confirmed (section 7, property 2)."""
    expected = "in sequence, each after the one before was confirmed"
    found = []
    for grip in story.grips:
        begun = {attempt.actuator: attempt.start_s for attempt in reversed(grip.attempts)}
        names = list(dict.fromkeys(attempt.actuator for attempt in grip.attempts))
        if names != list(description.sequence[: len(names)]):
            found.append("activated in the order " + ", ".join(names))
        found += [
            f"{after} activated before {before} was confirmed"
            for before, after in pairwise(names)
            if not _confirmed_by(grip, before, begun[after])
        ]
    return Finding("order", expected, "; ".join(found) or expected, not found)


def _confirmed_by(grip: Grip, actuator: str, at: float) -> bool:
    return any(
        attempt.outcome is AttemptOutcome.CONFIRMED and attempt.end_s is not None and attempt.end_s <= at
        for attempt in grip.of(actuator)
    )


def _pending(log: StatesLog) -> Finding:
    """Check that no actuator changes from OFF to ON without PENDING in between."""
    skipped = {
        name
        for before, row in pairwise(log.rows)
        for name, old, new in zip(log.actuators, before.actuators, row.actuators, strict=True)
        if (old, new) == (0, 2)
    }
    found = f"not of {', '.join(sorted(skipped))}" if skipped else "always"
    return Finding("pending", "between OFF and ON", found, not skipped)


def _unwound(description: Description, story: Story) -> Finding:
    """Check that actuators are deactivated one after the other, in the declared order."""
    names = [name for release in story.releases for name in release.deactivated]
    expected = [name for name in description.releasing if name in names]
    return _equal("deactivated", ", ".join(expected) or "none", ", ".join(names) or "none")


def _left_active(log: StatesLog) -> Finding:
    """Check that nothing is left active, except in a latched GRIP_ERROR."""
    last = log.rows[-1] if log.rows else None
    names = [
        name for name, state in zip(log.actuators, last.actuators if last else (), strict=False) if state
    ]
    kept = last is not None and last.end_effector is EndEffectorState.GRIP_ERROR
    return Finding("left active", "nothing", ", ".join(names) or "nothing", kept or not names)


def measures(
    description: Description, log: StatesLog, story: Story, slow_release: str | None
) -> list[Measure]:
    """Return every time-out and reset of the recording, and the wait for ``slow_release`` during the release."""
    actuators = description.actuators
    found = [
        Measure(
            f"{attempt.actuator} time-out {attempt.number}", actuators[attempt.actuator].timeout_s, length
        )
        for attempt in story.timeouts
        if (length := attempt.length_s) is not None
    ]
    count: Counter[str] = Counter()
    for reset in story.resets:
        count[reset.actuator] += 1
        name = f"{reset.actuator} reset {count[reset.actuator]}"
        found.append(Measure(name, actuators[reset.actuator].reset_s, reset.length_s))
    waited = _release_wait(log, slow_release) if slow_release else None
    if slow_release and waited is not None:
        found.append(Measure(f"{slow_release} release", actuators[slow_release].release_s, waited))
    return found


def _release_wait(log: StatesLog, actuator: str) -> float | None:
    """Return the time from the deactivation to the event that the actuator is not gone, s; None: no such event."""
    times = {each.kind: each.time_s for each in log.events or () if each.actuator == actuator}
    if EventKind.NOT_GONE not in times:
        return None
    return times[EventKind.NOT_GONE] - times.get(EventKind.DEACTIVATED, 0.0)


NEAR_MS = 250
TAKEN = "every command taken"
REPLAYED = "identical decisions, every step allowed by the automata"


def read_edges(path: Path) -> list[LineEdge]:
    """Return everything that was written to a virtual chip, from its file."""
    return ChipLog().feed(path.read_bytes())


def on_the_wires(description: Description, log: StatesLog, edges: Iterable[LineEdge]) -> Finding:
    """Compare the edges on the wires with the recording: the same ones, near their times.

    The two have different clocks; the median of the differences is taken as their offset. The executor reports how
    late an edge is; the limit here is wide enough for a busy machine, and for a device that is activated first.
    """
    recorded, seen = _recorded(log), _seen(description, edges)
    expected, found = ", ".join(map(str, recorded)) or "no edge", ", ".join(map(str, seen)) or "no edge"
    if expected != found:
        return Finding("wires", expected, found, ok=False)
    late_us = [edge.at - row.at for row, edge in zip(recorded, seen, strict=True)]
    worst_ms = max((abs(each - median(late_us)) / 1000 for each in late_us), default=0.0)
    outputs = description.register_outputs.values()
    near_ms = NEAR_MS + max(
        (each.activation.ready_within_s * 1000 for each in outputs if each.activation), default=0
    )
    what = f"each edge within {near_ms:g} ms of its row"
    return Finding("wires", what, f"one {worst_ms:.1f} ms off", ok=worst_ms <= near_ms)


def _recorded(log: StatesLog) -> list[Switching]:
    return [
        Switching(round(row.time_s * 1e6), name, new != 0)
        for before, row in pairwise(log.rows)
        for name, old, new in zip(log.actuators, before.actuators, row.actuators, strict=True)
        if (old != 0) != (new != 0)
    ]


def _seen(description: Description, edges: Iterable[LineEdge]) -> list[Switching]:
    """Return the edges that change something: the first record of an output shows only that it is driven."""
    active = dict.fromkeys(description.actuators, False)
    found = []
    for each in switchings(description, (Edge(edge.at, edge.line, edge.active) for edge in edges)):
        if each.active != active[each.name]:
            active[each.name] = each.active
            found.append(each)
    return found


def answered(folder: Path) -> Finding:
    """Report every command that was refused, with the reason that the client got."""
    try:
        refused = [each for path in traces_of(folder) for each in _refused(path)]
    except (ReportedError, KeyError) as error:
        refused = [str(error)]
    return Finding("answers", TAKEN, "; ".join(refused) or TAKEN, not refused)


def _refused(path: Path) -> Iterator[str]:
    command, trace = "", load_trace(path)
    for number, record in enumerate(trace.file.records):
        if record.kind == "command":
            command = str(trace.content(number)["name"])
        elif record.kind == "answer" and not (answer := trace.content(number))["accepted"]:
            yield f"{command} was refused: {answer['reason']}"


def replayed(folder: Path) -> Finding:
    """Replay the trace of a run, and have the monitor judge it."""
    try:
        faults = list(_all_faults(folder))
    except ReportedError as error:
        faults = [str(error)]
    return Finding("replay", REPLAYED, "; ".join(faults) or REPLAYED, not faults)


def _all_faults(folder: Path) -> Iterator[str]:
    before: SegmentEnd | None = None
    for path in traces_of(folder):
        found = review(load_trace(path), before=before)
        before = found.end
        yield from _faults(found)


def _faults(found: Review) -> Iterator[str]:
    name, seconds = found.trace.file.path.name, found.trace.seconds
    if found.replay.difference is not None:
        yield f"{name} at {seconds(found.replay.difference.at):.3f} s: {found.replay.difference}"
    for objection in found.objections:
        if objection.kind != "missed":
            yield f"{name} at {seconds(objection.at):.3f} s: {objection.what}"
