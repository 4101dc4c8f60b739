"""A tool that grips three parts, in virtual time: each with its own actuators, thresholds and time-outs."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.control import EventKind, event_lines
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.vocabulary import Cause, EndEffectorState, Evidence
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT

STAND_BY, GRIPPED = EndEffectorState.STAND_BY, EndEffectorState.GRIPPED
GRIP_ERROR = EndEffectorState.GRIP_ERROR
PARTS = """
parts:
  panel: {}
  box:
    uses: [bottom_vacuum, cylinder]
    actuators:
      bottom_vacuum: {confirmed_kpa: 30.0, lost_kpa: 25.0, lost_at_once_kpa: 15.0, timeout_s: 2.0, attempts: 2}
  lid: {uses: [top_vacuum]}
"""


@pytest.fixture(scope="module")
def description(tmp_path_factory: pytest.TempPathFactory) -> Description:
    path: Path = tmp_path_factory.mktemp("parts") / "end_effector.yaml"
    path.write_text(profile_path().read_text(encoding="utf-8") + PARTS, encoding="utf-8")
    return load(path)


def at_rest(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    assert (tool.status.ee, tool.status.part) == (STAND_BY, "")
    return tool


def gripped(description: Description, part: str, scenario: str = "nominal") -> VirtualTool:
    tool = at_rest(description, scenario)
    assert tool.command("grip", part=part).accepted
    tool.run(5.0)
    assert (tool.status.ee, tool.status.part) == (GRIPPED, part)
    return tool


@pytest.mark.parametrize(
    ("part", "active"),
    [("panel", (True, True, True)), ("box", (True, True, False)), ("lid", (False, False, True))],
)
def test_a_part_is_gripped_by_its_actuators_and_the_others_stay_inactive(
    description: Description, part: str, active: tuple[bool, ...]
) -> None:
    tool = gripped(description, part)
    assert tool.status.outputs == active
    assert tool.status.held
    assert tool.status.lift_allowed
    lines = [actuator.line for _, actuator in description.ordered]
    used = {line for line, uses in zip(lines, active, strict=True) if uses}
    assert {edge.line for edge in tool.edges if edge.level} & set(lines) == used
    assert tool.command("drop").accepted
    tool.run(3.0)
    assert (tool.status.ee, tool.status.part) == (STAND_BY, "")
    assert not any(tool.status.outputs)


def test_without_a_name_the_first_part_is_gripped(description: Description) -> None:
    tool = at_rest(description)
    assert tool.command("grip").accepted
    tool.run(5.0)
    assert (tool.status.ee, tool.status.part) == (GRIPPED, "panel")


def test_an_unknown_part_is_refused_with_those_that_there_are(description: Description) -> None:
    tool = at_rest(description)
    edges = len(tool.edges)
    answer = tool.command("grip", part="bxo")
    assert (answer.accepted, answer.reason) == (
        False, "There is no part 'bxo'; there are: panel, box, lid.",
    )  # fmt: skip
    assert len(tool.edges) == edges


def test_a_tool_that_names_no_parts_says_so() -> None:
    tool = VirtualTool(load(profile_path()))
    tool.run(1.0)
    assert (
        tool.command("grip", part="box").reason == "There is no part 'box'; the description has no `parts`."
    )


def test_the_thresholds_are_those_of_the_part(description: Description) -> None:
    weak = "shows:bottom_vacuum:-40"
    tool = at_rest(description)
    assert tool.command("grip", part="box").accepted
    tool.run(0.05)
    tool.choose(weak)
    tool.run(5.0)
    assert (tool.status.ee, tool.status.part) == (GRIPPED, "box")
    other = at_rest(description)
    assert other.command("grip", part="panel").accepted
    other.run(0.05)
    other.choose(weak)
    other.run_until(other.at + 30_000_000, lambda: other.status.cause is Cause.TIMED_OUT)
    assert "was not confirmed within 5 s in 3 attempts" in other.status.reason


def test_the_attempts_and_the_time_out_are_those_of_the_part(description: Description) -> None:
    tool = at_rest(description, "never-confirms:bottom_vacuum")
    begun = tool.at
    assert tool.command("grip", part="box").accepted
    tool.run_until(begun + 60_000_000, lambda: tool.status.cause is Cause.TIMED_OUT)
    assert 5.0 <= (tool.at - begun) / 1e6 <= 5.2, "two attempts of 2 s, and the pause of 1 s"
    assert tool.status.reason == "Bottom vacuum was not confirmed within 2 s in 2 attempts."
    said = [line for status in tool.statuses for line in event_lines(description, status)]
    assert "Bottom vacuum was not confirmed within 2 s: attempt 1 of 2." in said
    assert "STAND_BY -> GRIPPING (GRIP box)" in said


def test_what_is_held_stays_that_part_until_it_is_dropped(description: Description) -> None:
    tool = gripped(description, "box")
    refused = tool.command("grip", part="lid")
    assert refused.reason == "A grip is accepted in STAND_BY only; the end-effector is GRIPPED."
    tool.choose("shows:bottom_vacuum:-20")
    tool.run(1.0)
    assert (tool.status.ee, tool.status.cause, tool.status.part) == (GRIP_ERROR, Cause.LOST, "box")
    tool.choose("shows:bottom_vacuum:-35")  # enough for the box, not for the panel
    tool.run(1.0)
    assert tool.command("resume").accepted
    assert (tool.status.ee, tool.status.part) == (GRIPPED, "box")


def test_an_actuator_that_is_not_used_need_not_be_read_while_the_part_is_held(
    description: Description,
) -> None:
    tool = gripped(description, "lid")
    tool.choose("invalid:bottom_vacuum")
    tool.run(1.0)
    assert tool.status.ee is GRIPPED
    assert tool.status.evidence[0] is Evidence.UNKNOWN
    assert tool.status.lift_allowed
    assert tool.status.alarm("evidence.unread") is None


def test_a_grip_of_any_part_needs_everything_to_be_gone(description: Description) -> None:
    tool = at_rest(description, "shows:top_vacuum:-30")
    answer = tool.command("grip", part="box")
    assert not answer.accepted
    assert answer.reason.startswith("IL-07: ")
    assert tool.status.part == ""


@pytest.mark.parametrize("part", ["panel", "box", "lid"])
def test_a_program_that_starts_again_holds_the_same_part(description: Description, part: str) -> None:
    tool = gripped(description, part)
    held = tool.status.outputs
    tool.kill("hal")
    tool.run(3.0)
    tool.start("hal")
    tool.run(3.0)
    assert (tool.status.ee, tool.status.part, tool.status.outputs) == (GRIPPED, part, held)
    assert tool.status.lift_allowed


def test_the_part_outlives_the_line_arbiter(description: Description) -> None:
    tool = gripped(description, "box")
    tool.kill("hal")
    tool.kill("arbiter")
    tool.run(1.0)
    tool.start("arbiter")
    tool.start("hal")
    tool.run(3.0)
    assert (tool.status.ee, tool.status.part) == (GRIPPED, "box")


def test_evidence_of_another_part_does_not_make_a_grip_of_this_one(description: Description) -> None:
    """Outputs of the box are found active, and the record says that the lid is held."""
    tool = gripped(description, "box")
    tool.kill("hal")
    arbiter = tool._arbiters.now
    assert arbiter is not None
    for part, name in (("lid", "lid"), ("", ""), ("sold out", "")):
        arbiter.rules.part = part
        tool.start("hal")
        tool.run(3.0)
        assert (tool.status.ee, tool.status.cause) == (GRIP_ERROR, Cause.UNPROVEN_AT_START)
        assert (tool.status.part, tool.status.held) == (name, True)
        tool.kill("hal")
        tool.run(2.0)
    tool.start("hal")
    tool.run(3.0)
    assert tool.command("drop").accepted
    tool.run(3.0)
    assert tool.status.ee is STAND_BY


def test_a_step_is_an_event_of_the_part(description: Description) -> None:
    tool = gripped(description, "lid")
    steps = [
        event.actuator
        for status in tool.statuses
        for event in status.events
        if event.kind is EventKind.ATTEMPT_BEGAN
    ]
    assert steps == [2]
    assert [step.attempts for step in tool.status.steps] == [0, 0, 1]


UNLIKE = """
parts:
  box: {actuators: {bottom_vacuum: {gone_kpa: 19.0}}}
  lid:
    actuators:
      bottom_vacuum: {confirmed_kpa: 18.0, lost_kpa: 15.0, lost_at_once_kpa: 12.0, gone_kpa: 5.0}
"""


@pytest.fixture(scope="module")
def unlike(tmp_path_factory: pytest.TempPathFactory) -> Description:
    """What counts as gone for the default part would confirm the other one."""
    path: Path = tmp_path_factory.mktemp("unlike") / "end_effector.yaml"
    path.write_text(profile_path().read_text(encoding="utf-8") + UNLIKE, encoding="utf-8")
    return load(path)


@pytest.mark.parametrize("part", ["box", "lid"])
def test_what_any_part_takes_for_feedback_is_in_the_way_of_every_grip(unlike: Description, part: str) -> None:
    tool = VirtualTool(unlike, "shows:bottom_vacuum:-18.5")
    tool.run(1.0)
    answer = tool.command("grip", part=part)
    assert not answer.accepted
    assert answer.reason.startswith("IL-07: ")
    assert tool.status.ee is STAND_BY


def test_a_release_is_proven_by_the_values_of_every_part(unlike: Description) -> None:
    tool = gripped(unlike, "box")
    tool.choose("shows:bottom_vacuum:-8")
    tool.run(0.5)
    assert tool.command("drop").accepted
    tool.run(10.0)
    assert tool.status.ee is EndEffectorState.RELEASE_ERROR


def test_a_device_without_a_model_obeys_the_values_of_each_part() -> None:
    """The crate closes the fingers with a row of its own."""
    tool = VirtualTool(load(ROOT / "examples/cells/three_parts/end_effector.yaml"), models={})
    tool.run(1.0)
    for part in ("crate", "bracket"):
        assert tool.command("grip", part=part).accepted
        tool.run(10.0)
        assert (tool.status.ee, tool.status.alarm_texts) == (GRIPPED, ())
        assert tool.command("drop").accepted
        tool.run(5.0)
