"""The gripping function as it is executed, in virtual time: exact states, exact times."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load
from end_effector_hal.kinds.stanza import Opposite
from end_effector_hal.vocabulary import Cause
from tests.support.virtual_tool import VirtualTool

OFF, GRIPPING, GRIP_ERROR, GRIPPED, RELEASING, RELEASE_ERROR, STAND_BY = range(7)
NONE, GRIP, RELEASE, CANCEL = -1, 2, 3, 4
BOTTOM, CYLINDER, TOP = "SODIMM_208", "SODIMM_210", "SODIMM_212"


def ready(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    assert tool.status.ee == STAND_BY
    return tool


def gripped(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = ready(description, scenario)
    tool.play("grip", 3.0)
    assert tool.status.ee == GRIPPED
    return tool


def with_two_coils(description: Description) -> Description:
    """The valve of the bottom vacuum has them."""
    bottom = description.actuators["bottom_vacuum"]
    pulsed = bottom.model_copy(update={"opposite": Opposite(line="BACK", pulse_s=0.1)})
    return description.model_copy(update={"actuators": {**description.actuators, "bottom_vacuum": pulsed}})


def times_of(tool: VirtualTool, line: str) -> list[tuple[float, bool]]:
    return [(at / 1e6, level) for at, name, level in tool.edges if name == line]


def test_figure_7_grip_then_drop(verdin: Description) -> None:
    tool = gripped(verdin)
    tool.play("drop", 3.0)
    assert tool.states() == [
        (OFF, NONE, (0, 0, 0)),
        (STAND_BY, NONE, (0, 0, 0)),
        (GRIPPING, GRIP, (0, 0, 0)),
        (GRIPPING, GRIP, (1, 0, 0)),
        (GRIPPING, GRIP, (2, 0, 0)),
        (GRIPPING, GRIP, (2, 1, 0)),
        (GRIPPING, GRIP, (2, 2, 0)),
        (GRIPPING, GRIP, (2, 2, 1)),
        (GRIPPING, GRIP, (2, 2, 2)),
        (GRIPPED, NONE, (2, 2, 2)),
        (RELEASING, RELEASE, (2, 2, 2)),
        (RELEASING, RELEASE, (2, 2, 0)),
        (RELEASING, RELEASE, (2, 0, 0)),
        (RELEASING, RELEASE, (0, 0, 0)),
        (STAND_BY, NONE, (0, 0, 0)),
    ]
    assert [(line, level) for _, line, level in tool.edges] == [
        (BOTTOM, True), (CYLINDER, True), (TOP, True), (TOP, False), (CYLINDER, False), (BOTTOM, False),
    ]  # fmt: skip
    assert [(step.attempts, step.confirmed) for step in tool.status.steps] == [(1, True)] * 3


def test_figure_8_one_time_out_one_reset_success_on_attempt_2(verdin: Description) -> None:
    tool = ready(verdin, "fails-once:cylinder")
    tool.play("grip", 10.0)
    assert tool.status.ee == GRIPPED
    (start, _), (timeout, _), (again, _) = times_of(tool, CYLINDER)
    assert timeout - start == pytest.approx(5.0, abs=1e-9)
    assert again - timeout == pytest.approx(1.0, abs=1e-9)
    assert [step.attempts for step in tool.status.steps] == [1, 2, 1]


def test_figure_9_three_time_outs_abort_and_reverse_order(verdin: Description) -> None:
    tool = ready(verdin, "never-confirms:cylinder")
    tool.play("grip", 25.0)
    edges = times_of(tool, CYLINDER)
    assert [round(b - a, 6) for (a, _), (b, _) in pairwise(edges)] == [5.0, 1.0, 5.0, 1.0, 5.0]
    states = [(ee, command) for ee, command, _ in tool.states()]
    assert states.index((GRIP_ERROR, RELEASE)) < states.index((RELEASING, RELEASE)) < len(states) - 1
    assert states[-1] == (STAND_BY, NONE)
    assert [line for _, line, level in tool.edges if not level][-2:] == [CYLINDER, BOTTOM]
    assert not any(line == TOP for _, line, _ in tool.edges)
    status = tool.status
    assert (status.cause, status.cause_at) == (Cause.TIMED_OUT, 1)
    assert status.reason == "Cylinder was not confirmed within 5 s in 3 attempts."
    assert [(step.attempts, step.seconds) for step in status.steps] == [(1, 0.4), (3, 17.0), (0, 0.0)]


def test_cancel_while_gripping_unwinds(verdin: Description) -> None:
    tool = ready(verdin)
    tool.play("grip", 1.2)
    assert tool.status.ee == GRIPPING
    assert tool.command("cancel").accepted
    assert (tool.status.ee, tool.status.command) == (RELEASING, CANCEL)
    tool.run(3.0)
    assert tool.status.ee == STAND_BY
    assert tool.status.cause == Cause.CANCELLED
    released = [line for _, line, level in tool.edges if not level]
    assert released == [TOP, CYLINDER, BOTTOM][-len(released) :]


@pytest.mark.parametrize("late_ms", range(5, 105, 10))
def test_a_cancel_just_after_an_activation_ends_in_stand_by(verdin: Description, late_ms: int) -> None:
    """Its feedback may come when the actuator is inactive again, and was taken for gone."""
    tool = ready(verdin)
    tool.play("grip", 0.4 + late_ms / 1000)
    assert [line for _, line, active in tool.edges if active] == [BOTTOM, CYLINDER]
    tool.play("cancel", 2.5)
    assert (tool.status.ee, tool.status.cause) == (STAND_BY, Cause.CANCELLED)


def test_cancel_while_gripped_or_releasing_changes_nothing(verdin: Description) -> None:
    tool = gripped(verdin)
    answer = tool.command("cancel")
    assert not answer.accepted
    assert "no running grip" in answer.reason
    tool.run(5.0)
    assert tool.status.ee == GRIPPED
    tool.command("drop")
    assert not tool.command("cancel").accepted
    tool.run(3.0)
    assert tool.status.ee == STAND_BY


def test_a_second_grip_is_refused_and_changes_nothing(verdin: Description) -> None:
    tool = ready(verdin)
    tool.command("grip")
    before = tool.edges.copy()
    answer = tool.command("grip")
    assert not answer.accepted
    assert answer.reason == "A grip is accepted in STAND_BY only; the end-effector is GRIPPING."
    assert tool.edges == before


def test_a_lost_grip_is_latched_and_all_outputs_stay(verdin: Description) -> None:
    tool = gripped(verdin, "lost-after:bottom_vacuum:6")
    edges = tool.edges.copy()
    tool.run(10.0)
    assert tool.status.ee == GRIP_ERROR
    assert tool.status.cause == Cause.LOST
    assert tool.status.held
    assert not tool.status.lift_allowed
    assert tool.edges == edges
    assert not tool.command("grip").accepted
    tool.play("drop", 5.0)
    assert tool.status.ee == STAND_BY


def test_stale_while_gripped_freezes_and_tells(verdin: Description) -> None:
    tool = gripped(verdin)
    edges = tool.edges.copy()
    tool.link = False
    tool.run(5.0)
    status = tool.status
    assert status.ee == GRIPPED
    assert status.evidence == (0, 0, 0)
    assert not status.lift_allowed
    assert any("while it holds a part" in alarm for alarm in status.alarm_texts)
    assert tool.edges == edges
    tool.link = True
    tool.run(1.0)
    assert tool.status.lift_allowed


def test_a_channel_that_the_tool_does_not_use_is_not_told_stale(tmp_path: Path) -> None:
    file = tmp_path / "cups.yaml"
    file.write_text(
        "name: cups\nlink: {port: /dev/ttyS0}\nsequence: [front]\n"
        "actuators: {front: {kind: vacuum, line: A0, channel: bottom}}\n"
    )
    tool = VirtualTool(load(file))
    tool.run(1.0)
    assert {"cylinder", "top"} <= set(tool.codec.channels)
    assert tool.status.stale == ()
    tool.link = False
    tool.run(1.0)
    assert tool.status.stale == ("bottom", "supply")


def test_stale_while_gripping_confirms_nothing(verdin: Description) -> None:
    tool = ready(verdin)
    tool.command("grip")
    tool.link = False
    tool.run(30.0)
    assert tool.status.ee == RELEASE_ERROR  # absence is not proven
    assert tool.status.cause == Cause.NOT_PROVEN
    assert not any(tool.levels.values())
    tool.link = True
    tool.play(1.0, "drop", 1.0)
    assert tool.status.ee == STAND_BY


def test_release_error_is_latched_until_a_drop_succeeds(verdin: Description) -> None:
    tool = gripped(verdin, "stuck-release:bottom_vacuum")
    tool.play("drop", 5.0)
    assert tool.status.ee == RELEASE_ERROR
    assert tool.status.reason.startswith(
        "Everything is deactivated, but Bottom vacuum still shows feedback: bottom is at -"
    )
    assert "; gone means less than 10 kPa below ambient." in tool.status.reason
    assert not any(tool.levels.values())  # nothing is left on
    assert not tool.command("grip").accepted
    assert tool.command("drop").accepted
    assert tool.status.ee == RELEASING  # it may be gone in its time
    tool.run(1.9)
    assert tool.status.ee == RELEASING
    tool.run(0.2)
    assert tool.status.ee == RELEASE_ERROR
    tool.bench.choose("nominal", tool.at)
    tool.play(2.0, "drop", 1.0)
    assert tool.status.ee == STAND_BY


def test_a_drop_in_stand_by_releases_once_more_what_is_not_proven_gone_and_nothing_else(
    verdin: Description,
) -> None:
    tool = ready(verdin)
    refused = tool.command("drop")
    assert not refused.accepted
    assert "in STAND_BY while something is not proven to be gone" in refused.reason
    tool.bench.devices["bottom_vacuum"].command(True, tool.at)  # somebody has switched its valve
    tool.run(1.0)
    refused = tool.command("grip")
    assert refused.reason.startswith(
        "IL-07: Bottom vacuum shows feedback although it is not active: bottom is at -"
    )
    assert "gone means less than 10 kPa below ambient" in refused.reason
    assert "ambient pressure or the zero of the sensor differs" in refused.reason
    assert refused.reason.endswith("A Drop releases it once more.")
    edges = len(tool.edges)
    assert tool.command("drop").accepted
    assert (tool.status.ee, tool.status.command, tool.status.dropped) == (RELEASING, RELEASE, 0)
    tool.bench.devices["bottom_vacuum"].command(False, tool.at)
    tool.run(1.5)
    assert (tool.status.ee, tool.status.dropped) == (STAND_BY, -1)
    assert len(tool.edges) == edges


@pytest.mark.parametrize(
    ("active", "state"),
    [((), STAND_BY), ((BOTTOM, CYLINDER, TOP), GRIPPED), ((BOTTOM,), GRIP_ERROR)],
)
def test_adoption_moves_no_line(verdin: Description, active: tuple[str, ...], state: int) -> None:
    tool = VirtualTool(verdin, levels=dict.fromkeys(active, True))
    tool.run(1.5)
    assert tool.status.ee == state
    assert tool.edges == []
    assert tool.status.held == bool(active)


@pytest.mark.parametrize(
    ("levels", "state"),
    [({BOTTOM: True}, GRIP_ERROR), ({BOTTOM: False}, STAND_BY), ({}, STAND_BY)],
    ids=["recorded active", "recorded inactive", "unknown"],
)
def test_what_nobody_knows_of_two_coils_is_decided_by_the_sensors_and_nothing_else(
    verdin: Description, levels: dict[str, bool], state: int
) -> None:
    """Its sensors say gone: that never overrules a level or a record, or a broken wire would drop a part."""
    tool = VirtualTool(with_two_coils(verdin), found=levels)
    tool.run(1.5)
    assert tool.status.ee == state


def test_what_nobody_knows_and_no_sensor_proves_gone_is_held(verdin: Description) -> None:
    tool = VirtualTool(with_two_coils(verdin), found={})
    tool.link = False
    tool.run(5.1)
    assert (tool.status.ee, tool.status.held) == (GRIP_ERROR, True)


def test_active_outputs_without_sensors_are_a_latched_error(verdin: Description) -> None:
    tool = VirtualTool(verdin, levels={BOTTOM: True, CYLINDER: True, TOP: True})
    tool.link = False
    tool.run(4.9)
    assert (tool.status.ee, tool.status.held) == (OFF, True)
    tool.run(0.2)
    assert tool.status.ee == GRIP_ERROR
    assert tool.status.cause == Cause.UNPROVEN_AT_START
    assert tool.edges == []


def test_who_reads_the_link_may_start_later(verdin: Description) -> None:
    """After a start of everything: a part that is held and proven a little later is no error."""
    tool = VirtualTool(verdin, levels={BOTTOM: True, CYLINDER: True, TOP: True})
    tool.link = False
    tool.run(3.0)
    tool.link = True
    tool.run(0.5)
    assert tool.status.ee == GRIPPED
    assert tool.edges == []


def test_active_outputs_with_a_reading_that_is_invalid_wait_a_second(verdin: Description) -> None:
    tool = VirtualTool(verdin, "invalid:top_vacuum", levels={BOTTOM: True, CYLINDER: True, TOP: True})
    tool.run(0.9)
    assert tool.status.ee == OFF
    tool.run(0.2)
    assert tool.status.ee == GRIP_ERROR


@pytest.mark.parametrize(
    ("scenario", "reason"),
    [
        ("supply:300", "IL-06: the supply pressure is 300 kPa, a grip requires at least 400 kPa."),
        (
            "invalid:top_vacuum",
            "IL-07: Top vacuum is not proven to be gone: top has no valid reading; gone means less than 10 kPa "
            "below ambient. Check its sensor.",
        ),
    ],
)
def test_interlocks_refuse_a_grip_with_a_sentence(verdin: Description, scenario: str, reason: str) -> None:
    tool = VirtualTool(verdin, scenario)
    tool.run(2.0)
    answer = tool.command("grip")
    assert not answer.accepted
    assert answer.reason == reason
    assert tool.edges == []


def test_unlock_excludes_grip_and_relocks_by_itself(verdin: Description) -> None:
    tool = ready(verdin)
    assert tool.command("unlock").accepted
    assert not tool.command("grip").accepted
    tool.run(1.0)
    assert tool.status.changer == 2
    assert "IL-05" in tool.command("grip").reason
    tool.run(4.0)
    line = verdin.tool_changer.line if verdin.tool_changer else ""
    (on, _), (off, _) = times_of(tool, line)
    assert off - on == pytest.approx(
        2.95
    )  # IL-03: at most 3 s, also when it is taken late by the reaction bound
    assert tool.status.changer == 1
    assert tool.command("grip").accepted
    assert not tool.command("unlock").accepted


def test_unlock_is_refused_while_gripped(verdin: Description) -> None:
    tool = gripped(verdin)
    answer = tool.command("unlock")
    assert not answer.accepted
    assert answer.reason == "IL-01: unlock only in STAND_BY; the end-effector is GRIPPED."
