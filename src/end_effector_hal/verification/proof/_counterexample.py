"""Write a run that refutes a requirement: as text with absolute times, and with the files of a recorded run.

It also explains in words why a requirement does not hold, with the values that the requirement names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from end_effector_hal.errors import RangeError
from end_effector_hal.recording import COUNTEREXAMPLE, RunInfo, StatesLog, Watched, check_replaceable
from end_effector_hal.verification import Draw, has_states, states_of, write_run
from end_effector_hal.verification.proof._finding import Finding
from timed_automata import Network
from timed_automata.explain import Explanation, Names, WatchedClock, explain, explain_time
from timed_automata.queries import parse_query

_LIKE = "actuator"
_ALSO = ("cause_at",)


def names_in(network: Network, actuators: Sequence[str]) -> Names:
    """Return the names of a network's values, with those of the actuators in sequence order."""
    return Names(network, actuators, _LIKE, _ALSO)


def why(finding: Finding, names: Names) -> Explanation:
    """Return the explanation why a requirement does not hold.

    Args:
        finding: a finding with a trace.
        names: the names of the trace's network.
    """
    trace = finding.trace
    assert trace is not None
    try:
        return (
            explain(trace, parse_query(finding.query), names) if finding.query else explain_time(trace, names)
        )
    except (RangeError, ArithmeticError, LookupError, TypeError, ValueError, RecursionError):
        # the last step of the run is what leaves a range; and words never cost a verdict
        return Explanation(f"{trace.remark.rstrip('.')}.", ())


def write_counterexample(
    finding: Finding, folder: str | Path, info: RunInfo, draw: Draw, actuators: Sequence[str] = ()
) -> list[Path]:
    """Write ``<id>/run.txt``; if the model has their variables also the tables, ``run.json`` and the timeline.

    Args:
        finding: with a trace.
        folder: made if it is missing.
        info: what the figure says about the model.
        draw: writes the timeline of the states into a folder and returns its files.
        actuators: their names in sequence order.

    Raises:
        UsageError: the folder cannot be written, or holds a recording.
    """
    trace = finding.trace
    if trace is None:
        return []
    place = Path(folder) / finding.id
    check_replaceable(place)
    lines = (finding.sentence, finding.query, "", *told_run(finding, actuators))
    return write_run(place, lines, counterexample_run(finding, info, actuators), draw)


def told_run(finding: Finding, actuators: Sequence[str] = ()) -> list[str]:
    """Return the run that refutes a requirement as text: its steps, and at last why it refutes it."""
    trace = finding.trace
    if trace is None:
        return []
    names = names_in(trace.network, actuators)
    return [*trace.lines_with(names), "", why(finding, names).sentence]


def counterexample_run(
    finding: Finding, info: RunInfo, actuators: Sequence[str] = ()
) -> tuple[StatesLog, RunInfo] | None:
    """Return the states of a run that refutes a requirement, and its run info; None: there is none."""
    if finding.trace is None or not has_states(finding.trace.network):
        return None
    network = finding.trace.network
    found = why(finding, names_in(network, actuators))
    info = replace(
        info,
        scenario=COUNTEREXAMPLE,
        simulated=True,
        violated=finding.sentence,
        violated_s=_seconds(finding.trace.end),
        because=found.sentence,
        watched=_watched(found),
    )
    return states_of(finding.trace, actuators), info


def _watched(found: Explanation) -> tuple[Watched, ...]:
    """Return the watched values with times in seconds."""
    return tuple(
        Watched(
            each.name,
            each.wrong,
            points=tuple((_seconds(at), _seconds(value)) for at, value in each.points),
            limits=tuple((words, _seconds(value)) for words, value in each.limits),
            deadline_s=None if each.deadline is None else _seconds(each.deadline),
        )
        if isinstance(each, WatchedClock)
        else Watched(each.name, each.wrong, values=tuple((_seconds(at), words) for at, words in each.changes))
        for each in found.watched
    )


def _seconds(ms: Fraction | int) -> float:
    return float(ms) / 1000
