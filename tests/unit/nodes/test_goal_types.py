"""What a goal of each action asks for, and what it says at its end; it needs no ROS."""

from __future__ import annotations

import logging
from math import inf, isnan, nan
from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control.goals import Ending, Outcome
from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes._goal_types import GoalType, goal_types
from end_effector_hal.nodes.interface import COMMAND_ACTIONS, GRIPPER_COMMAND, PARALLEL_GRIPPER_COMMAND
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence
from tests.support.parts import with_parts

GONE, PARTIAL, CONFIRMED = Evidence.GONE, Evidence.PARTIAL, Evidence.CONFIRMED
JOINT = "verdin_gripper_joint"
LOG = logging.getLogger("tests.goal_types")


def kind(name: str) -> GoalType:
    return next(each for each in goal_types(load(profile_path()), LOG) if each.action.name == name)


@pytest.fixture
def gripper() -> GoalType:
    return kind(GRIPPER_COMMAND.name)


@pytest.fixture
def parallel() -> GoalType:
    return kind(PARALLEL_GRIPPER_COMMAND.name)


def one(position: float, max_effort: float = 0.0) -> Any:
    return SimpleNamespace(command=SimpleNamespace(position=position, max_effort=max_effort))


def joints(*position: float, name: list[str] | None = None, effort: tuple[float, ...] = ()) -> Any:
    names = [JOINT] if name is None else name
    return SimpleNamespace(command=SimpleNamespace(name=names, position=position, velocity=[], effort=effort))


def state(*evidence: Evidence, part: str = "") -> Any:
    return SimpleNamespace(
        evidence=evidence, part=part, state=EndEffectorState.GRIPPING, state_name="GRIPPING", steps=["a step"]
    )


def test_every_action_has_its_goals() -> None:
    actions = [each.action for each in goal_types(load(profile_path()), LOG)]
    assert actions == [*COMMAND_ACTIONS, GRIPPER_COMMAND, PARALLEL_GRIPPER_COMMAND]


@pytest.mark.parametrize(
    ("position", "command"),
    [(0.0, Command.GRIP), (1e-4, Command.GRIP), (-0.009, Command.GRIP), (1.0, Command.RELEASE),
     (0.9999, Command.RELEASE), (1.009, Command.RELEASE)],
)  # fmt: skip
def test_the_ends_of_the_joint_are_commands(
    gripper: GoalType, parallel: GoalType, position: float, command: Command
) -> None:
    assert gripper.command(one(position)) is command
    assert parallel.command(joints(position)) is command


@pytest.mark.parametrize("position", [0.02, 0.5, 0.98, 1.02, -0.02, nan, inf, -inf, 1e300])
def test_nothing_between_or_beyond_is_a_command(
    gripper: GoalType, parallel: GoalType, position: float
) -> None:
    why = f"The position {position:g} is not valid for this tool: 0 grips, 1 drops."
    assert gripper.command(one(position)) == parallel.command(joints(position)) == why


@pytest.mark.parametrize(
    ("request_", "found"),
    [
        (joints(1.0, name=[]), "0 names (no joint) and 1 positions"),
        (joints(1.0, name=["elbow"]), "1 names (elbow) and 1 positions"),
        (joints(1.0, name=["el\nbow"]), "1 names (el bow) and 1 positions"),
        (joints(1.0, name=[JOINT, "elbow"]), f"2 names ({JOINT}, elbow) and 1 positions"),
        (joints(1.0, name=["j"] * 1000), "1000 names (j, j) and 1 positions"),
        (joints(), f"1 names ({JOINT}) and 0 positions"),
        (joints(1.0, 1.0), f"1 names ({JOINT}) and 2 positions"),
    ],
)
def test_only_the_one_joint_is_ours(parallel: GoalType, request_: Any, found: str) -> None:
    expected = f"The goal has {found}, expected are one position of {JOINT}."
    assert parallel.command(request_) == expected


def test_that_an_effort_is_ignored_is_told_once(
    gripper: GoalType, parallel: GoalType, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO):
        gripper.command(one(0.0))
        parallel.command(joints(0.0, effort=(0.0,)))
        assert caplog.messages == []
        for _ in range(2):
            gripper.command(one(0.0, 40.0))
            parallel.command(joints(1.0, effort=(40.0,)))
    assert caplog.messages == [
        "gripper_controller/gripper_cmd: max_effort is ignored: the air sets force and speed. Logged once.",
        "parallel_gripper_controller/gripper_cmd: velocity and effort are ignored: "
        "the air sets force and speed. Logged once.",
    ]


@pytest.mark.parametrize("outcome", Outcome)
@pytest.mark.parametrize("command", [Command.GRIP, Command.RELEASE, None])
@pytest.mark.parametrize("evidence", [GONE, CONFIRMED])
def test_nothing_but_a_success_reaches_the_goal_or_holds_something(
    gripper: GoalType, parallel: GoalType, outcome: Outcome, command: Command | None, evidence: Evidence
) -> None:
    """Also where the sensors show what was asked for: MoveIt takes an aborted goal that stalled for a success."""
    for each in (gripper, parallel):
        result = each.result(state(*[evidence] * 3), Ending(outcome, "why", 1.0), command)
        assert result.reached_goal == (outcome is Outcome.SUCCEEDED)
        assert result.stalled == (outcome is Outcome.SUCCEEDED and command is Command.GRIP)


@pytest.mark.parametrize(
    ("evidence", "position"),
    [((CONFIRMED,) * 3, 0.0), ((GONE,) * 3, 1.0), ((CONFIRMED, CONFIRMED, GONE), None), ((PARTIAL,) * 3, None),
     ((Evidence.UNKNOWN,) * 3, None), ((7, 7, 7), None)],
)  # fmt: skip
def test_the_joint_stands_where_all_sensors_prove_it(
    gripper: GoalType, parallel: GoalType, evidence: Any, position: float | None
) -> None:
    found = gripper.feedback(cast("Any", state(*evidence)))
    assert isnan(found.position) if position is None else found.position == position
    assert isnan(found.effort)
    assert not found.stalled
    joint = parallel.feedback(state(*evidence)).state
    assert (joint.name, joint.position) == (([], []) if position is None else ([JOINT], [position]))


def test_the_steps_are_those_of_a_grip_that_was_begun() -> None:
    drop, grip = kind("Drop"), kind("TriggerGrip")
    begun, refused = Ending(Outcome.FAILED, "why", 2.5), Ending(Outcome.REJECTED, "why")
    now = state(GONE)
    assert grip.result(now, begun, Command.GRIP).steps == ["a step"]
    assert grip.result(now, begun, Command.GRIP).seconds == 2.5
    assert grip.result(now, refused, Command.GRIP).steps == []
    assert drop.result(now, begun, Command.RELEASE).steps == []
    assert (grip.command(named("")), drop.command(named(""))) == (Command.GRIP, Command.RELEASE)


def named(part: str) -> Any:
    return SimpleNamespace(part=part)


def test_only_a_grip_is_for_a_part() -> None:
    grip = kind("TriggerGrip")
    assert (grip.command(named("lid")), grip.part(named("lid"))) == (Command.GRIP, "lid")
    for name in ("Drop", "LockToolChanger", "UnlockToolChanger"):
        assert kind(name).command(named("lid")) == f"Only a grip is for a part: {name} needs an empty `part`."


def test_the_name_of_a_part_is_bounded(gripper: GoalType) -> None:
    part = kind("TriggerGrip").part(named("l\nid" * 1_000_000))
    assert part.startswith("l idl id")
    assert len(part) == 64
    assert gripper.part(one(0.0)) == ""


@pytest.mark.parametrize(("part", "position"), [("lid", 0.0), ("panel", nan), ("", nan)])
def test_the_joint_is_at_0_where_all_that_grip_the_part_are_confirmed(part: str, position: float) -> None:
    types = {each.action: each for each in goal_types(with_parts(load(profile_path())), LOG)}
    found = types[GRIPPER_COMMAND].feedback(state(GONE, PARTIAL, CONFIRMED, part=part))
    assert found.position == pytest.approx(position, nan_ok=True)
