"""Evidence that a description declares: it replaces what the kind would prove, in the whole product."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.codecs import get_codec, load_tool
from end_effector_hal.description import Description, not_fitted, used_channels
from end_effector_hal.description.rules._channels import CodecChannels
from end_effector_hal.errors import DescriptionError
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Cause, EndEffectorState, Evidence
from tests.support.virtual_tool import VirtualTool

HEAD = """\
name: tool
link: {port: /dev/ttyS0}
sequence: [cup, rod]
supply: {channel: none}
actuators:
  cup: {kind: vacuum, line: A, channel: bottom}
  rod:
    kind: cylinder
    line: B
    channel: none
    evidence:
"""
SWITCHES = """\
      confirmed: {all: [{on: cylinder_extended}, {not: {on: cylinder_retracted}}], for_ms: 50}
      gone: {on: cylinder_retracted}
"""
EMPTY = (
    SWITCHES
    + "      empty: {not: {any: [{on: cylinder_extended}, {on: cylinder_retracted}]}, for_ms: 1500}\n"
)
PERIOD = 20_000


@pytest.fixture
def tool(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Description]:
    monkeypatch.chdir(tmp_path)

    def load(evidence: str) -> Description:
        Path("tool.yaml").write_text(HEAD + evidence, encoding="utf-8")
        return load_tool("tool.yaml")

    return load


def test_a_tool_grips_and_drops_by_its_conditions(tool: Callable[[str], Description]) -> None:
    virtual = VirtualTool(tool(SWITCHES))
    virtual.run(1.0)
    assert virtual.command("grip").accepted
    virtual.run(3.0)
    assert virtual.status.ee == EndEffectorState.GRIPPED
    virtual.command("drop")
    virtual.run(3.0)
    assert virtual.status.ee == EndEffectorState.STAND_BY


def test_it_is_what_is_dumped_and_read_again(tool: Callable[[str], Description]) -> None:
    description = tool(EMPTY)
    content = description.model_dump(mode="json", by_alias=True, exclude={"automata": {"file"}})
    Path("again.yaml").write_text(json.dumps(content), "utf-8")
    again = load_tool("again.yaml")
    assert again.actuators["rod"].evidence == description.actuators["rod"].evidence
    assert again.fingerprint() == description.fingerprint() != tool(SWITCHES).fingerprint()


def test_only_what_its_conditions_ask_for_is_used(tool: Callable[[str], Description]) -> None:
    description = tool("      confirmed: {on: cylinder_extended}\n      gone: {on: in_stand}\n")
    assert used_channels(description) == ("bottom", "cylinder_extended", "in_stand")
    codec = get_codec("ees1-ascii")
    carried = CodecChannels(codec.name, codec.channels, codec.period_us, 0.15)
    assert not [said for said in not_fitted(description, carried) if said.startswith("rod")]


@pytest.mark.parametrize(
    ("evidence", "faults"),
    [
        (
            "      confirmed: {on: cylinder_extendet}\n      gone: {on: cylinder_retracted}\n",
            [
                "12:23: ees1-ascii carries no 'cylinder_extendet' (cylinder_extendet), expected a bit of ees1-ascii: "
                "locked, unlocked, tool_present, in_stand, cylinder_extended, cylinder_retracted, estop_ok; "
                "did you mean 'cylinder_extended'? [EE-225]"
            ],
        ),
        (
            "      confirmed: {any: [{on: cylinder_extended}, {on: nowhere}]}\n      gone: {on: bottom}\n",
            [
                "12:55: ees1-ascii carries no 'nowhere' (nowhere), expected a bit of ees1-ascii: locked, unlocked, "
                "tool_present, in_stand, cylinder_extended, cylinder_retracted, estop_ok [EE-225]",
                "13:18: 'bottom' is a pressure (on: bottom), expected a bit [EE-225]",
            ],
        ),
        (
            "      confirmed: {channel: locked, above_kpa: 3}\n      gone: {on: unlocked, for_ms: 2000}\n",
            [
                "12:28: 'locked' is a bit (locked), expected a pressure; write {on: locked} [EE-225]",
                "13:13: 'rod' can never be gone: it takes 2 s (ees1-ascii), expected less than release_s = 2 [EE-225]",
            ],
        ),
        (
            "      confirmed: {all: [{on: locked, for_ms: 4000}], samples: 51}\n      gone: {on: unlocked}\n",
            [
                "12:18: 'rod' can never be confirmed: it takes 5 s (ees1-ascii), expected less than timeout_s = 5 "
                "[EE-225]"
            ],
        ),
    ],
)
def test_what_no_wire_carries_is_a_sentence_at_its_place(
    tool: Callable[[str], Description], evidence: str, faults: list[str]
) -> None:
    with pytest.raises(DescriptionError) as caught:
        tool(evidence)
    assert caught.value.faults == [f"tool.yaml:{each}" for each in faults]


def test_a_threshold_that_the_pressure_never_passes_is_refused(tool: Callable[[str], Description]) -> None:
    cup = "    evidence: {confirmed: {channel: bottom, below_kpa: 55}, gone: {channel: bottom, above_kpa: -10}}\n"
    text = HEAD.replace(
        "{kind: vacuum, line: A, channel: bottom}",
        f"\n    kind: vacuum\n    line: A\n    channel: bottom\n{cup}",
    )
    Path("tool.yaml").write_text(text + SWITCHES, encoding="utf-8")
    with pytest.raises(DescriptionError) as caught:
        load_tool("tool.yaml")
    assert caught.value.faults == [
        "tool.yaml:10:56: a vacuum circuit cannot have 55 kPa (55), expected -110 to 50 kPa gauge; gauge pressure "
        "below ambient is negative here; write below_kpa: -55 [EE-227]"
    ]


class Bits:
    """Frames at 50 Hz of the two switches."""

    def __init__(self, description: Description) -> None:
        self.senses, self.at = SensorSet(description, get_codec("ees1-ascii")), 0

    def __call__(self, seconds: float, extended: bool | None, retracted: bool | None) -> Evidence:
        for _ in range(round(seconds * 50)):
            self.at += PERIOD
            values = {"bottom": 0, "cylinder_extended": extended, "cylinder_retracted": retracted}
            self.senses.frame(Frame(self.at, None, None, values))
        return self.senses.now.evidence[1]

    @property
    def notices(self) -> tuple[str, ...]:
        return tuple(map(str, self.senses.notices(self.at, held=False)))


def test_contradicting_switches_are_unknown_at_once_and_an_alarm_when_it_lasts(
    tool: Callable[[str], Description],
) -> None:
    bits = Bits(tool(SWITCHES))
    assert bits(0.1, False, True) is Evidence.GONE
    said = bits.notices
    assert bits(0.1, True, True) is Evidence.UNKNOWN
    assert bits.notices == said
    assert bits(0.5, True, True) is Evidence.UNKNOWN
    assert bits.notices == (
        "The sensors of Rod contradict each other (cylinder_extended is on, cylinder_retracted is on): they prove "
        "nothing. Is one broken, or wired wrongly?",
        *said,
    )
    assert bits(0.1, False, True) is Evidence.GONE
    assert bits.notices == said


def test_empty_is_told_while_it_is_so_and_in_the_reason_of_the_failure(
    tool: Callable[[str], Description],
) -> None:
    bits = Bits(tool(EMPTY))
    assert bits(2.0, False, False) is Evidence.PARTIAL
    assert "Rod has gripped nothing." in bits.notices
    assert bits(0.1, True, False) is Evidence.CONFIRMED
    assert "Rod has gripped nothing." not in bits.notices


def test_what_is_lost_is_told_by_what_its_channels_show(tool: Callable[[str], Description]) -> None:
    virtual = VirtualTool(tool(SWITCHES), "lost-after:rod:3")
    virtual.run(1.0)
    virtual.command("grip")
    virtual.run(5.0)
    status = virtual.status
    assert (status.ee, status.cause, status.cause_at) == (EndEffectorState.GRIP_ERROR, Cause.LOST, 1)
    assert status.reason == "Rod was lost: cylinder_extended is off, cylinder_retracted is off."
