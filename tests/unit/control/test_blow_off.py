"""A release blows the part off: when, for how long, and when not; exact lines in virtual time."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.arbiter import arbiter_policy
from end_effector_hal.control import GripLastWill, ending_in_words, event_lines, model_constants, network_of
from end_effector_hal.description import Description
from end_effector_hal.verification.proof import prove
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from tests.support.blown import BOTTOM_AIR, TOP_AIR, blown
from tests.support.declared import declared
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool

BOTTOM, CYLINDER, TOP = "SODIMM_208", "SODIMM_210", "SODIMM_212"
MS = 1000
STAND_BY, RELEASING, RELEASE_ERROR = (
    EndEffectorState.STAND_BY,
    EndEffectorState.RELEASING,
    EndEffectorState.RELEASE_ERROR,
)


def gripped(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.play(1.0, "grip", 4.0)
    assert tool.status.ee == EndEffectorState.GRIPPED
    assert not [line for _, line, _ in tool.edges if line in (BOTTOM_AIR, TOP_AIR)]
    return tool


def dropped(tool: VirtualTool, seconds: float = 10.0) -> list[tuple[int, str, bool]]:
    """What the lines do after a Drop: ms, line, level."""
    since, before = tool.at, len(tool.edges)
    tool.play("drop", seconds)
    return [((at - since) // MS, line, level) for at, line, level in tool.edges[before:]]


def test_after_the_gap_it_blows_for_its_time_and_rests_before_the_next_output_moves() -> None:
    tool = gripped(blown())
    edges = dropped(tool)
    assert [edge[1:] for edge in edges] == [
        (TOP, False), (TOP_AIR, True), (TOP_AIR, False), (CYLINDER, False),
        (BOTTOM, False), (BOTTOM_AIR, True), (BOTTOM_AIR, False),
    ]  # fmt: skip
    times = [at for at, _, _ in edges]
    # gap_s of 50 ms, 50 ms for a line that settles, 50 ms of lateness; and 200 ms of blowing
    assert (times[1] - times[0], times[2] - times[1], times[3] - times[2]) == (150, 200, 150)
    assert (times[5] - times[4], times[6] - times[5]) == (150, 200)
    assert tool.status.ee == STAND_BY


def test_until_gone_it_ends_with_the_feedback() -> None:
    edges = dropped(gripped(blown(until_gone=True)))
    on, off = (at for at, line, _ in edges if line == TOP_AIR)
    assert 20 <= off - on < 150


def test_what_is_gone_already_is_not_blown_off_where_the_feedback_ends_it() -> None:
    tool = VirtualTool(blown(until_gone=True), "never-confirms:bottom_vacuum")
    tool.play(1.0, "grip", 0.5, "cancel", 3.0)
    assert [line for _, line, _ in tool.edges] == [BOTTOM, BOTTOM]
    assert tool.status.ee == STAND_BY


def test_nothing_is_blown_off_between_two_attempts() -> None:
    """The cups before it hold the part."""
    tool = VirtualTool(blown(), "fails-once:top_vacuum")
    tool.play(1.0, "grip", 9.0)
    assert tool.status.ee == EndEffectorState.GRIPPED
    assert [line for _, line, _ in tool.edges].count(TOP) == 3
    assert not [line for _, line, _ in tool.edges if line in (BOTTOM_AIR, TOP_AIR)]


def test_nothing_is_blown_off_while_an_output_stays_active_as_declared() -> None:
    tool = VirtualTool(blown(declared(bottom_vacuum={"gripping": {"cancel": "hold"}})))
    tool.play(1.0, "grip", 1.1)
    assert tool.levels[TOP]
    tool.play("cancel", 8.0)
    assert tool.levels[BOTTOM]
    assert not tool.levels[TOP]
    assert not [line for _, line, _ in tool.edges if line in (BOTTOM_AIR, TOP_AIR)]
    assert (BOTTOM_AIR, True) in [edge[1:] for edge in dropped(tool)]  # a Drop leaves nothing held


def test_a_part_that_sticks_comes_off_by_blowing_alone() -> None:
    assert dropped(tool := gripped(blown(), "sticks:top_vacuum"))
    assert tool.status.ee == STAND_BY
    dropped(tool := gripped(blown(duration_s=None), "sticks:top_vacuum"))
    assert (tool.status.ee, tool.status.evidence[2]) == (RELEASE_ERROR, Evidence.CONFIRMED)


def test_blowing_is_no_proof() -> None:
    """Its sensor shows a vacuum all the time: the release waits after the blow-off as without it."""
    tool = gripped(blown())
    tool.bench.choose("shows:top_vacuum:-70", tool.at)
    edges = dropped(tool)
    times = {edge[1:]: edge[0] for edge in edges}
    assert times[CYLINDER, False] - times[TOP_AIR, False] == 150 + 2000
    assert tool.status.ee == RELEASE_ERROR


@pytest.mark.parametrize("command", ["grip", "drop", "cancel", "unlock"])
def test_no_command_disturbs_it(command: str) -> None:
    tool = gripped(blown())
    tool.play("drop", 0.2)
    assert tool.status.blowing == (2,)
    assert not tool.command(command).accepted
    before = len(tool.edges)
    tool.run(0.2)
    assert [edge[1:] for edge in tool.edges[before:]] == [(TOP_AIR, False)]


def test_a_link_that_falls_silent_does_not_prolong_it() -> None:
    tool = gripped(blown(until_gone=True), "nominal")
    tool.play("drop", 0.151)
    tool.link = False
    before = tool.at
    tool.run(10.0)
    ends = [at for at, line, level in tool.edges if line == TOP_AIR and not level]
    assert [at - before <= 250 * MS for at in ends] == [True]
    assert tool.status.ee == RELEASE_ERROR  # nothing is proven
    assert not any(tool.levels.values())


def test_a_refusal_of_the_line_arbiter_goes_on_without_it() -> None:
    tool = gripped(blown())
    tool.play("drop", 0.16)
    assert tool.status.blowing == (2,)
    tool._told(tool.controller.refused(tool.at))
    assert tool.status.blowing == ()
    assert tool.status.ee == RELEASING
    tool.run(8.0)
    assert (tool.status.ee, tool.status.reason) == (STAND_BY, "")


def test_a_last_will_ends_it_first_and_begins_none() -> None:
    description = blown()
    tool = gripped(description)
    assert tool.command("drop").accepted
    wills = {}
    for _ in range(30):
        tool.run(0.02)
        wills[tool.status.blowing] = GripLastWill(description).of(tool.status)
    assert [(step.line, step.level, step.after_us) for step in wills[2,]] == [
        (TOP_AIR, False, 0), (CYLINDER, False, 0), (BOTTOM, False, 2_000_000),
    ]  # fmt: skip
    assert not {step.line for step in wills[()]} & {TOP_AIR, BOTTOM_AIR}
    status = next(status for status in tool.statuses if status.blowing)
    assert "Top vacuum" not in ending_in_words(description, status, on="process_death")
    held = replace(status, blowing=(), held=True, outputs=(True, True, True))
    assert GripLastWill(description).of(held) == ()


def test_it_is_told() -> None:
    tool = gripped(blown())
    dropped(tool)
    told = [line for status in tool.statuses for line in event_lines(tool.description, status)]
    assert [line for line in told if "blown" in line] == [
        "Top vacuum is blown off.",
        "Bottom vacuum is blown off.",
    ]


def test_the_line_arbiter_bounds_it_and_keeps_the_tool_locked_meanwhile() -> None:
    policy = arbiter_policy(blown())
    assert {policy.max_active_us[line] for line in (BOTTOM_AIR, TOP_AIR)} == {300 * MS}
    assert policy.bounded_by(TOP_AIR) == "IL-08"
    assert {each.line: each.gap_us for each in policy.partners(TOP_AIR)} == {"SODIMM_206": 0, TOP: 50 * MS}
    guarded = arbiter_policy(blown(duration_s=None))
    assert TOP_AIR not in guarded.max_active_us
    assert [each.line for each in guarded.partners(TOP_AIR)] == [TOP]


@pytest.mark.parametrize("until_gone", first_of([False, True], 0, 1))
def test_it_is_proven_and_its_time_is_in_the_bounds(until_gone: bool) -> None:
    proof = prove(network_of(blown(until_gone=until_gone)))
    assert [finding.id for finding in proof.findings if not finding.holds] == []
    longer = 2 * (150 + 200 + 150 + 3 * 50)
    for key, plain in (("release_s", 6150), ("cancel_s", 6150), ("grip_s", 57_900)):
        bound = proof.bounds[key]
        assert bound.computed_ms == bound.declared_ms == plain + longer


def test_a_description_that_drives_none_blows_nothing() -> None:
    constants = model_constants(blown(duration_s=None))
    assert constants["BLOWS"] is False
    assert {key: constants[key] for key in ("T_BLOW", "T_GAP")} == {"T_BLOW": [0, 0, 0], "T_GAP": [0, 0, 0]}
