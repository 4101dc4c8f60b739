"""Recordings made in virtual time tell their stories; a recording that is wrong in one point does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from end_effector_hal.control import EventKind
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.recording import EventRow, StatesLog, StatesRow, run_info
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.demo import DemoScenario, Report, scenarios
from end_effector_lab.demo._judge import judge
from end_effector_lab.demo._progress import Progress

NAMES = ["nominal", "fails-once", "never-confirms", "cancel", "stuck-release", "unlock-lock"]
Rows = list[StatesRow]
Events = list[EventRow]


@pytest.fixture
def told(verdin: Description, recordings: dict[str, StatesLog]) -> Callable[..., Report]:
    """The report on a recording, after an edit of its rows or its events."""

    def tell(
        name: str,
        edit: Callable[[Rows], Rows] = list,
        description: Description = verdin,
        events: Callable[[Events], Events] = list,
    ) -> Report:
        scenario = next(each for each in scenarios(verdin, everything=True) if each.name == name)
        log = recordings[name]
        edited = replace(log, rows=tuple(edit(list(log.rows))), events=tuple(events(list(log.events or ()))))
        assert (edit, events) == (list, list) or edited != log
        return judge(scenario, description, edited)

    return tell


@pytest.mark.parametrize("name", NAMES)
def test_every_scenario_tells_its_story(told: Callable[..., Report], name: str) -> None:
    assert told(name).faults == ()


def test_what_was_measured_stands_beside_the_description(told: Callable[..., Report]) -> None:
    assert [str(measure) for measure in told("never-confirms").measures] == [
        "cylinder time-out 1: 5.000 s (expected 5 s)",
        "cylinder time-out 2: 5.000 s (expected 5 s)",
        "cylinder time-out 3: 5.000 s (expected 5 s)",
        "cylinder reset 1: 1.000 s (expected 1 s)",
        "cylinder reset 2: 1.000 s (expected 1 s)",
    ]
    assert [str(measure) for measure in told("stuck-release").measures] == [
        "cylinder release: 2.000 s (expected 2 s)"
    ]
    assert told("nominal").measures == ()
    assert told("fails-once").attempts == {"bottom_vacuum": 1, "cylinder": 2, "top_vacuum": 1}


def test_the_expected_times_are_those_of_the_description(
    verdin: Description, told: Callable[..., Report]
) -> None:
    cylinder = verdin.actuators["cylinder"].model_copy(update={"timeout_s": 4.0, "reset_s": 1.2})
    other = verdin.model_copy(update={"actuators": {**verdin.actuators, "cylinder": cylinder}})
    assert told("fails-once", description=other).faults == (
        "cylinder time-out 1: 5.000 s (expected 4 s): not within 100 ms after it",
        "cylinder reset 1: 1.000 s (expected 1.2 s): not within 100 ms after it",
    )


def moved(seconds: float) -> Callable[[Events], Events]:
    """Everything from the first time-out of the cylinder on comes later."""

    def edit(events: Events) -> Events:
        out = next(i for i, event in enumerate(events) if event.kind is EventKind.TIMED_OUT)
        return events[:out] + [replace(event, time_s=event.time_s + seconds) for event in events[out:]]

    return edit


@pytest.mark.parametrize(
    ("seconds", "ok"),
    [(-0.001, False), (-0.00001, False), (0.00001, True), (0.099, True), (0.1, True), (0.101, False)],
)
def test_never_early_and_at_most_100_ms_late(told: Callable[..., Report], seconds: float, ok: bool) -> None:
    report = told("fails-once", events=moved(seconds))
    assert report.ok is ok
    assert report.measures[0].ok is ok
    assert report.measures[1].ok


def without(*states: EndEffectorState) -> Callable[[Rows], Rows]:
    return lambda rows: [row for row in rows if row.end_effector not in states]


def with_actuators(edit: Callable[[tuple[int, ...]], tuple[int, ...]]) -> Callable[[Rows], Rows]:
    return lambda rows: [replace(row, actuators=edit(row.actuators)) for row in rows]


def commanded(old: Command, new: Command) -> Callable[[Rows], Rows]:
    return lambda rows: [replace(row, command=new) if row.command is old else row for row in rows]


def named(names: dict[str, str], *kinds: EventKind) -> Callable[[Events], Events]:
    """Other actuators in the events of some kinds."""
    return lambda events: [
        replace(each, actuator=names.get(each.actuator, each.actuator)) if each.kind in kinds else each
        for each in events
    ]


WRONG: list[tuple[str, str, Callable[[Rows], Rows]]] = [
    ("nominal", "start", lambda rows: [row for row in rows if row.time_s > 1.2]),
    ("nominal", "commands", commanded(Command.LOCK, Command.NONE)),
    ("nominal", "commands", commanded(Command.RELEASE, Command.CANCEL)),
    ("nominal", "states", without(EndEffectorState.RELEASING)),
    ("nominal", "states", lambda rows: rows[:-1]),
    ("nominal", "pending", lambda rows: [row for row in rows if 1 not in row.actuators[1:2]]),
    ("nominal", "left active", with_actuators(lambda a: (a[0], a[1], max(a[2], 1)))),
    ("never-confirms", "states", without(EndEffectorState.GRIP_ERROR)),
    ("never-confirms", "commands", commanded(Command.RELEASE, Command.GRIP)),
    ("never-confirms", "left active", lambda rows: [*rows[:-1], replace(rows[-1], actuators=(2, 0, 0))]),
    ("cancel", "states", lambda rows: rows[:-1]),
    (
        "stuck-release",
        "states",
        lambda rows: [*rows[:-1], replace(rows[-1], end_effector=EndEffectorState.STAND_BY)],
    ),
    ("unlock-lock", "commands", commanded(Command.UNLOCK, Command.NONE)),
]


_ENDS = {"bottom_vacuum": "top_vacuum", "top_vacuum": "bottom_vacuum"}
WRONG_EVENTS: list[tuple[str, str, Callable[[Events], Events]]] = [
    ("nominal", "attempts", lambda events: [each for each in events if each.actuator != "top_vacuum"]),
    ("nominal", "order", named(_ENDS, EventKind.ATTEMPT_BEGAN, EventKind.CONFIRMED)),
    ("nominal", "deactivated", named(_ENDS, EventKind.DEACTIVATED)),
    ("fails-once", "time-outs", lambda events: [each for each in events if each.kind != EventKind.TIMED_OUT]),
]


@pytest.mark.parametrize(("name", "what", "edit"), WRONG_EVENTS)
def test_a_wrong_event_is_found(
    told: Callable[..., Report], name: str, what: str, edit: Callable[[Events], Events]
) -> None:
    report = told(name, events=edit)
    assert what in [finding.what for finding in report.findings if not finding.ok]


@pytest.mark.parametrize(("name", "what", "edit"), WRONG)
def test_what_is_wrong_is_found(
    told: Callable[..., Report], name: str, what: str, edit: Callable[[Rows], Rows]
) -> None:
    report = told(name, edit)
    assert not report.ok
    assert what in [finding.what for finding in report.findings if not finding.ok]


def test_a_recording_without_a_row_is_no_story(told: Callable[..., Report]) -> None:
    report = told("nominal", lambda rows: [])
    assert not report.ok
    assert "start: expected at rest, found nothing recorded" in report.faults


def test_the_report_as_json(told: Callable[..., Report]) -> None:
    content = told("fails-once").as_json()
    assert content["scenario"] == "fails-once"
    assert content["figure"] == "Fig. 8"
    assert content["outcome"] == "Cylinder confirmed on attempt 2: GRIPPED, then dropped"
    assert content["ok"] is True
    assert content["measured"][0] == {
        "what": "cylinder time-out 1",
        "expected_s": 5.0,
        "measured_s": 5.0,
        "ok": True,
    }


def test_scenarios_are_values() -> None:
    assert DemoScenario.__dataclass_params__.frozen  # type: ignore[attr-defined]


BEGUN = "time_s,end_effector,command,bottom_vacuum,cylinder,top_vacuum\n0.0,6,-1,0,0,0\n"
ABORTED = "18.7,1,2,2,1,0\n18.8,2,3,2,0,0\n18.8,4,3,0,0,0\n"


def test_an_error_that_is_unwound_at_once_is_said(tmp_path: Path) -> None:
    states = tmp_path / "states.csv"
    progress = Progress(Console(file=StringIO()), "[1/1]", states, run_info(load(profile_path())))
    assert progress.news() == []
    states.write_text(BEGUN)
    assert progress.news() == ["STAND_BY"]
    states.write_text(BEGUN + ABORTED)
    assert progress.news() == [
        "GRIPPING, Bottom vacuum ON, Cylinder PENDING EXTEND",
        "GRIP_ERROR, Bottom vacuum ON",
        "RELEASING",
    ]
    assert progress.news() == []
