"""Tools of the kinds that switches prove, in virtual time against the testbench's physics."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Status, event_lines, network_of
from end_effector_hal.description import examine_text
from end_effector_hal.errors import DescriptionError
from end_effector_hal.verification.proof import prove
from end_effector_hal.vocabulary import Cause, EndEffectorState, Evidence
from tests.support.virtual_tool import VirtualTool

TOOLS = Path(__file__).parent / "tools"
GRIPPED, STAND_BY, GRIP_ERROR = (
    EndEffectorState.GRIPPED,
    EndEffectorState.STAND_BY,
    EndEffectorState.GRIP_ERROR,
)


def ready(name: str, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(load_tool(TOOLS / f"{name}.yaml"), scenario)
    tool.run(1.0)
    return tool


def gripped(name: str, scenario: str = "nominal") -> VirtualTool:
    tool = ready(name, scenario)
    assert tool.command("grip").accepted
    tool.run(4.0)
    return tool


@pytest.mark.parametrize("name", [each.stem for each in TOOLS.glob("*.yaml")])
def test_it_grips_and_drops(name: str) -> None:
    tool = gripped(name)
    assert tool.status.ee == GRIPPED
    assert tool.status.lift_allowed
    assert tool.status.secure  # nothing is known that speaks against it
    tool.command("drop")
    tool.run(3.0)
    assert tool.status.ee == STAND_BY
    assert not any(tool.status.outputs)


def test_an_attempt_that_closes_on_nothing_is_over_at_once() -> None:
    tool = ready("gripper", "no-part:jaw")
    assert tool.command("grip").accepted
    tool.run(6.0)
    line = tool.description.actuators["jaw"].line
    attempts = [at for at, name, level in tool.edges if name == line and level]
    ends = [at for at, name, level in tool.edges if name == line and not level]
    assert len(attempts) == len(ends) == 3
    lengths = [end - at for at, end in zip(attempts, ends, strict=True)]
    assert max(lengths) < 1_000_000  # its time-out is 2 s
    pauses = [at - end for at, end in zip(attempts[1:], ends, strict=False)]
    assert min(pauses) >= 1_000_000
    given_up = next(status for status in tool.statuses if status.ee == GRIP_ERROR)
    assert (given_up.cause, given_up.cause_at) == (Cause.EMPTY, 0)
    assert "Jaw closed on nothing." in given_up.alarm_texts
    assert tool.status.ee == STAND_BY
    assert tool.status.reason == "Jaw closed on nothing: all 3 attempts have failed."
    assert "Jaw closed on nothing." not in tool.status.alarm_texts
    lines = [line for status in tool.statuses for line in event_lines(tool.description, status)]
    assert [line for line in lines if "attempt " in line] == [
        f"Jaw closed on nothing: attempt {number} of 3." for number in (1, 2, 3)
    ]


def test_what_was_shown_before_an_attempt_says_nothing_of_it() -> None:
    """A finger that hangs shows "closed" all the time: it has had no chance to grip."""
    tool = ready("gripper")
    assert tool.command("grip").accepted
    status = feed(tool, 2.9, cylinder_extended=True, cylinder_retracted=False)
    assert (status.ee, status.steps[0].attempts) == (EndEffectorState.GRIPPING, 2)
    assert status.outputs == (True,)  # for 1.8 s


def test_a_tool_that_shows_empty_is_proven() -> None:
    proof = prove(network_of(load_tool(TOOLS / "gripper.yaml")))
    assert [finding.id for finding in proof.findings if not finding.holds] == []
    assert not any("empty[i]" in edge for edge in proof.off)


def test_fingers_whose_part_is_pulled_out_have_lost_it_and_stay_closed() -> None:
    tool = gripped("gripper", "lost-after:jaw:3")
    assert tool.status.ee == GRIP_ERROR
    assert (tool.status.cause, tool.status.outputs) == (Cause.LOST, (True,))
    assert tool.status.reason == "Jaw was lost: cylinder_retracted is off, cylinder_extended is on."


def feed(tool: VirtualTool, seconds: float, **bits: bool) -> Status:
    """What the switches show, whatever the physics is."""
    sample = tool.bench.sample
    tool.bench.sample = lambda at: {**sample(at), **bits}  # type: ignore[method-assign]
    tool.run(seconds)
    tool.bench.sample = sample  # type: ignore[method-assign]
    return tool.status


def test_both_end_switches_at_once_hold_what_is_held_and_refuse_a_grip() -> None:
    tool = gripped("gripper")
    status = feed(tool, 1.0, cylinder_extended=True, cylinder_retracted=True)
    assert (status.ee, status.evidence, status.outputs) == (GRIPPED, (Evidence.UNKNOWN,), (True,))
    assert not status.lift_allowed
    assert any("The sensors of Jaw contradict each other" in alarm for alarm in status.alarm_texts)
    tool.run(2.0)
    assert (tool.status.evidence, tool.status.lift_allowed) == ((Evidence.CONFIRMED,), True)
    tool = ready("gripper")
    feed(tool, 1.0, cylinder_extended=True, cylinder_retracted=True)
    assert not tool.command("grip").accepted


def test_a_switch_that_chatters_loses_nothing() -> None:
    tool = gripped("vacuum_switch")
    assert feed(tool, 0.02, in_stand=False).ee == GRIPPED
    tool.run(1.0)
    assert tool.status.ee == GRIPPED
    assert feed(tool, 0.1, in_stand=False).ee == GRIP_ERROR
    tool = gripped("gripper")
    assert feed(tool, 0.02, cylinder_extended=True).ee == GRIPPED
    assert feed(tool, 0.1, cylinder_extended=True).ee == GRIP_ERROR


def test_a_magnet_that_is_switched_off_has_not_released_before_its_sensor_says_so() -> None:
    tool = gripped("magnet")
    tool.command("drop")
    status = feed(tool, 3.0, cylinder_extended=True, cylinder_retracted=False)
    assert (status.ee, status.outputs) == (EndEffectorState.RELEASE_ERROR, (False,))
    # its part lies still in its place: neither gripped nor gone
    assert feed(tool, 0.5, cylinder_extended=False, cylinder_retracted=False).evidence == (Evidence.PARTIAL,)


def test_switches_that_change_one_after_the_other_are_no_alarm() -> None:
    """The part is gone a little before its own switch says so: for 40 ms neither is proven."""
    tool = gripped("magnet")
    told = len(tool.statuses)
    tool.command("drop")
    feed(tool, 0.04, cylinder_extended=True, cylinder_retracted=True)
    feed(tool, 1.0, cylinder_extended=False, cylinder_retracted=True)
    seen = tool.statuses[told:]
    assert Evidence.UNKNOWN in {status.evidence[0] for status in seen}
    assert [status.alarm_texts for status in seen if status.alarm_texts] == []
    assert tool.status.ee == STAND_BY


def test_a_part_that_is_seen_between_open_fingers_is_not_gripped() -> None:
    tool = ready("vacuum_switch")
    assert feed(tool, 0.5, tool_present=True).evidence[2] is Evidence.GONE
    assert tool.command("grip").accepted


@pytest.mark.parametrize(
    ("stanza", "fault"),
    [
        (
            "{kind: gripper, line: A}",
            "4:13: nothing proves that it has gripped, expected part_bit, or open_bit and closed_bit, or evidence",
        ),
        (
            "{kind: gripper, line: A, open_bit: opened, closed_bit: none}",
            "4:13: opened alone proves no part, expected part_bit, or open_bit and closed_bit, or evidence",
        ),
        (
            "{kind: magnet, line: A, gone_bit: away}",
            "4:13: nothing proves that it has gripped, expected part_bit, or evidence",
        ),
    ],
)
def test_what_nothing_could_prove_is_refused(stanza: str, fault: str) -> None:
    text = f"name: t\nlink: {{port: /dev/ttyS0}}\nsequence: [it]\nactuators: {{it: {stanza}}}\n"
    assert examine_text(text, "t.yaml").lines() == [f"t.yaml:{fault} [EE-225]"]


BITS = "locked, unlocked, tool_present, in_stand, cylinder_extended, cylinder_retracted, estop_ok"


@pytest.mark.parametrize(
    ("stanza", "fault"),
    [
        (
            "{kind: magnet, line: A, part_bit: lockd}",
            f"4:51: ees1-ascii carries no 'lockd' (lockd), expected a bit of ees1-ascii: {BITS}; "
            "did you mean 'locked'? if there is no such sensor, write part_bit: none",
        ),
        (
            "{kind: vacuum, line: A, channel: none, part_bit: top}",
            "4:66: 'top' is a pressure (part_bit: top), expected a bit",
        ),
        (
            "{kind: gripper, line: A, open_bit: locked, closed_bit: unlocked, settle_ms: 5000}",
            "4:13: 'it' can never be confirmed: it takes 5 s (ees1-ascii), expected less than timeout_s = 5",
        ),
    ],
)
def test_what_the_link_cannot_prove_is_refused(stanza: str, fault: str, tmp_path: Path) -> None:
    path = tmp_path / "t.yaml"
    path.write_text(f"name: t\nlink: {{port: /dev/ttyS0}}\nsequence: [it]\nactuators: {{it: {stanza}}}\n")
    with pytest.raises(DescriptionError) as caught:
        load_tool(path)
    assert caught.value.faults == [f"{path}:{fault} [EE-225]"]


@pytest.mark.parametrize("stanza", ["kind: gripper", "kind: magnet"])
def test_evidence_of_its_own_is_enough(stanza: str) -> None:
    evidence = "evidence: {confirmed: {on: locked}, gone: {on: unlocked}}"
    actuator = f"{{{stanza}, line: A, {evidence}}}"
    text = f"name: t\nlink: {{port: /dev/ttyS0}}\nsequence: [it]\nactuators: {{it: {actuator}}}\n"
    assert examine_text(text, "t.yaml").lines() == []
