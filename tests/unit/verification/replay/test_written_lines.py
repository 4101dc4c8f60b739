"""What was written to the lines, held against what was decided."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.arbiter import HAL, client_lines
from end_effector_hal.control import GripLastWill, Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime.boundary import LinesWritten, Start
from end_effector_hal.verification.replay._written_lines import WrittenLines
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence

DESCRIPTION = load(profile_path())
BOTTOM, CYLINDER, TOP, UNLOCK = client_lines(DESCRIPTION, HAL)
Will = tuple[dict[str, object], ...]
OFF = (False, False, False)
FAILED = "the line arbiter cannot be reached."


class Run:
    """A program that has adopted inactive lines."""

    def __init__(self) -> None:
        self.judge = WrittenLines(DESCRIPTION)
        assert list(self.judge.begin(Start(0, {}))) == []
        self.at = 0
        self.statuses: list[Status] = []
        self.decide(EndEffectorState.STAND_BY, OFF)
        assert self.write(dict.fromkeys((BOTTOM, CYLINDER, TOP, UNLOCK), False)) == []

    def decide(self, ee: EndEffectorState, outputs: tuple[bool, ...]) -> None:
        self.at += 1
        self.statuses.append(status(ee, outputs, self.at))
        self.judge.status(self.statuses[-1])

    def write(
        self, levels: dict[str, bool], error: str = "", will: Will | None = None, *, final: bool = False
    ) -> list[str]:
        """With the last will of the latest status, or another one."""
        self.at += 1
        will = will_of(self.statuses[-1]) if will is None else will
        record = LinesWritten(self.at, 1, levels, will, error)
        found = list(self.judge.lines(record, final=final))
        assert {each.kind for each in found} <= {"no run"}
        return [each.what.partition(" (")[0].partition(" that was left")[0] for each in found]

    def restart(self, **levels: bool) -> list[str]:
        """The program finds these lines active."""
        self.at += 1
        found = {line: levels.get(line, False) for line in (BOTTOM, CYLINDER, TOP)}
        return [each.what for each in self.judge.begin(Start(self.at, found))]


def will_of(status: Status, on: str = "process_death") -> Will:
    return tuple(step.as_json() for step in GripLastWill(DESCRIPTION).of(status, on=on))


def off(*lines: str) -> Will:
    """The last will that deactivates lines at once, as of maintenance."""
    return tuple({"line": line, "level": False, "after_us": 0} for line in lines)


def status(
    ee: EndEffectorState = EndEffectorState.STAND_BY, outputs: tuple[bool, ...] = OFF, at: int = 0
) -> Status:
    return Status(at, ee, Command.NONE, (2, 2, 2), outputs, (Evidence.GONE,) * 3, adopted=True)


def test_each_write_is_what_a_decision_changes() -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, OFF)
    run.decide(EndEffectorState.GRIPPING, (True, False, False))
    assert run.write({BOTTOM: True}) == []
    run.decide(EndEffectorState.RELEASING, (True, False, False))
    run.decide(EndEffectorState.RELEASING, OFF)
    assert run.write({}, will=will_of(run.statuses[-2])) == []
    assert run.write({BOTTOM: False}) == []


@pytest.mark.parametrize("levels", [{BOTTOM: False}, {TOP: True}, {BOTTOM: True, TOP: True}])
def test_what_no_decision_asks_for_is_an_objection(levels: dict[str, bool]) -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, OFF)
    run.decide(EndEffectorState.GRIPPING, (True, False, False))
    assert run.write(levels)


def test_a_level_that_was_asked_for_once_is_not_written_twice() -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, False, False))
    assert run.write({BOTTOM: True}) == []
    run.decide(EndEffectorState.GRIPPING, (True, True, False))
    assert run.write({BOTTOM: True, CYLINDER: True}) == ["Bottom vacuum"]


def test_what_failed_is_owed() -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, True, False))
    assert run.write({BOTTOM: True, CYLINDER: True}) == []
    run.decide(EndEffectorState.RELEASING, (True, False, False))
    assert run.write({CYLINDER: False}, FAILED) == []
    run.decide(EndEffectorState.RELEASING, OFF)
    assert run.write({CYLINDER: False, BOTTOM: False}) == []
    assert run.write({CYLINDER: False}) == ["Cylinder"]


def test_maintenance_drives_in_stand_by_alone() -> None:
    run = Run()
    assert run.write({TOP: True}, will=off(TOP)) == []
    assert run.write({BOTTOM: True}, will=off(TOP, BOTTOM)) == []
    assert run.write({BOTTOM: False}, will=off(TOP)) == []
    assert run.write({}, will=off(TOP)) == []
    assert run.write({TOP: False}) == []
    assert run.write({TOP: False}) == ["Top vacuum"]
    run.decide(EndEffectorState.GRIPPING, OFF)
    assert run.write({TOP: True}) == ["Top vacuum"]


def test_maintenance_leaves_its_last_will() -> None:
    assert Run().write({TOP: True}) == ["The last will"]
    run = Run()
    assert run.write({TOP: True}, will=off(TOP)) == []
    assert run.write({BOTTOM: True}, will=off(BOTTOM, TOP)) == ["The last will"]


def test_the_end_of_maintenance_is_written_with_its_last_will() -> None:
    run = Run()
    assert run.write({TOP: True}, will=off(TOP)) == []
    assert run.write({}) == ["The last will"]
    assert run.write({TOP: False}, will=off(TOP)) == []
    assert run.write({}) == []


def test_the_unlock_output_is_written_with_a_last_will_that_locks() -> None:
    for will, found in ((off(UNLOCK), []), ((), ["The last will"])):
        run = Run()
        run.statuses.append(replace(status(at=run.at), unlock_output=True))
        run.judge.status(run.statuses[-1])
        assert run.write({UNLOCK: True}, will=will) == found
        run.decide(EndEffectorState.STAND_BY, OFF)
        assert run.write({UNLOCK: False}) == []
        assert run.write({UNLOCK: True}) == [UNLOCK]


def test_a_last_will_that_was_not_left_leaves_the_one_before() -> None:
    for error, found in ((FAILED, 0), ("", 1)):
        run = Run()
        run.decide(EndEffectorState.GRIPPING, (True, True, True))
        assert run.write({BOTTOM: True, CYLINDER: True, TOP: True}) == []
        run.statuses.append(replace(status(EndEffectorState.GRIPPED, (True, True, True)), held=True))
        run.judge.status(run.statuses[-1])
        assert run.write({}, error) == []
        assert len(run.restart()) == found


def test_what_was_not_written_is_an_objection() -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, False, False))
    run.decide(EndEffectorState.GRIPPING, (True, True, False))
    assert run.write({CYLINDER: True}) == ["Bottom vacuum"]
    run.decide(EndEffectorState.GRIPPING, (True, True, True))
    assert run.write({}) == ["The last will"]


def test_what_was_decided_while_the_arbiter_was_lost_is_not_written() -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, False, False))
    run.judge.lose()
    run.decide(EndEffectorState.RELEASING, OFF)
    assert run.write({}) == []
    run.decide(EndEffectorState.GRIPPING, (False, False, True))
    assert run.write({TOP: True}) == []
    run.decide(EndEffectorState.GRIPPING, (False, True, True))
    run.decide(EndEffectorState.GRIPPING, (True, True, True))
    assert run.write({BOTTOM: True}) == ["Cylinder"], "it is there again"


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize(("key", "value"), [("line", TOP), ("level", True), ("after_us", 1), ("level", 0)])
def test_each_step_of_a_last_will_is_judged(number: int, key: str, value: object) -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, True, False))
    will = will_of(run.statuses[-1])
    assert [step["line"] for step in will] == [CYLINDER, BOTTOM]
    for false in (will[:number], will[::-1], (*will, will[number]), ({**will[0], "x": 1}, will[1])):
        other = Run()
        other.decide(EndEffectorState.GRIPPING, (True, True, False))
        assert other.write({BOTTOM: True, CYLINDER: True}, will=false) == ["The last will"]
    changed = tuple(step | {key: value} if n == number else step for n, step in enumerate(will))
    assert run.write({BOTTOM: True, CYLINDER: True}, will=changed) == ["The last will"]


def test_the_end_of_a_program_may_leave_something_else() -> None:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, True, False))
    assert run.write({BOTTOM: True, CYLINDER: True}) == []
    parting = will_of(run.statuses[-1], "sigterm")
    assert run.write({}, will=parting, final=True) == []
    assert run.write({}, will=off(CYLINDER), final=True) == ["The last will"]


def gripping() -> Run:
    run = Run()
    run.decide(EndEffectorState.GRIPPING, (True, True, False))
    assert run.write({BOTTOM: True, CYLINDER: True}) == []
    return run


def test_a_death_leaves_what_its_last_will_leaves() -> None:
    assert gripping().restart() == []
    assert gripping().restart(**{BOTTOM: True, CYLINDER: True}) == []  # it was not executed
    (half,) = gripping().restart(**{CYLINDER: True})  # in another order than the last will
    assert half.startswith("Bottom vacuum was found inactive and Cylinder active")
    (more,) = gripping().restart(**{BOTTOM: True, CYLINDER: True, TOP: True})
    assert more.startswith(f"Top vacuum ({TOP}) was found active, and nothing had activated it")


def test_what_is_held_is_not_released_by_a_death() -> None:
    run = gripping()
    run.decide(EndEffectorState.GRIPPED, (True, True, True))
    run.statuses[-1] = replace(run.statuses[-1], held=True)
    run.judge.status(run.statuses[-1])
    assert will_of(run.statuses[-1]) == ()
    assert run.write({TOP: True}, will=()) == []
    (fell,) = run.restart(**{BOTTOM: True, CYLINDER: True})
    assert fell.startswith("Top vacuum was found inactive")


def test_what_was_written_when_the_arbiter_was_lost_may_be_there_or_not() -> None:
    for found in ({}, {BOTTOM: True}, {BOTTOM: True, CYLINDER: True}):
        run = Run()
        run.decide(EndEffectorState.GRIPPING, (True, False, False))
        assert run.write({BOTTOM: True}) == []
        run.decide(EndEffectorState.GRIPPING, (True, True, False))
        assert run.write({CYLINDER: True}, FAILED) == []
        assert run.restart(**found) == []


def test_a_segment_that_begins_in_the_middle_is_judged_from_its_first_change_on() -> None:
    judge = WrittenLines(DESCRIPTION)
    assert list(judge.lines(LinesWritten(1, 1, {TOP: True}, ()))) == []
    judge.status(status(EndEffectorState.GRIPPED, (True, True, True)))
    assert list(judge.lines(LinesWritten(2, 1, {TOP: True}, ()))) == []
    judge.status(status(EndEffectorState.RELEASING, (True, True, False)))
    will = will_of(status(EndEffectorState.RELEASING, (True, True, False)))
    assert list(judge.lines(LinesWritten(3, 1, {TOP: False}, will))) == []
    assert len(list(judge.lines(LinesWritten(4, 1, {BOTTOM: False}, will)))) == 1
