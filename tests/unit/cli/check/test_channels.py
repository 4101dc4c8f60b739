"""Channels that a codec does not carry, or that an actuator cannot use, are refused at their place."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from end_effector_hal.codecs import codec_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from tests.unit.cli.check.conftest import NO_E_STOP, SHIPPED, TRANSMITTERS, Check, sentences

# A key of each kind of device, as it stands in the shipped file, and what it is called by
KEYS = [
    ("channel: cylinder\n", "channel: cylindr\n", "cylindr", "pressure", "channel", "cylinder"),
    ("channel: cylinder\n", "channel: cylinder\n    extended_bit: cylinder_extendd\n", "cylinder_extendd", "bit",
     "extended_bit", "cylinder_extended"),
    ("channel: cylinder\n", "channel: cylinder\n    retracted_bit: cylinder_retractd\n", "cylinder_retractd", "bit",
     "retracted_bit", "cylinder_retracted"),
    ("supply:\n", "supply:\n  channel: suply\n", "suply", "pressure", "channel", "supply"),
    *(
        ("  service: SetToolChanger", f"  {key}: {wrong}", wrong, "bit", key, meant)
        for key, wrong, meant in (
            ("locked_bit", "loked", "locked"),
            ("unlocked_bit", "unloked", "unlocked"),
            ("stand_bit", "in_stan", "in_stand"),
            ("present_bit", "tool_presnt", "tool_present"),
        )
    ),
    ("bounds:", "e_stop:\n  channel: estop_o\n\nbounds:", "estop_o", "bit", "channel", "estop_ok"),
]  # fmt: skip


OTHERS = ("cylinder_retractd", "unloked", "in_stan", "tool_presnt")
"""Further keys of a device of which a key is tried already."""


@pytest.mark.parametrize(
    ("old", "new", "wrong", "kind", "key", "meant"),
    [pytest.param(*each, id=each[2], marks=[pytest.mark.thinned] if each[2] in OTHERS else []) for each in KEYS],
)  # fmt: skip
def test_a_channel_that_no_wire_carries_is_refused_for_every_device(
    check: Check, old: str, new: str, wrong: str, kind: str, key: str, meant: str
) -> None:
    result = check(replace={old: new})
    assert result.exit_code == 2
    (said,) = sentences(result)
    line = SHIPPED.replace(old, new).partition(f"{key}: {wrong}")[0].count("\n") + 1
    assert said.startswith(f"tool.yaml:{line}:")
    assert f": ees1-ascii carries no '{wrong}' ({wrong}), expected a {kind} of ees1-ascii: " in said
    assert said.endswith(f"; did you mean '{meant}'? if there is no such sensor, write {key}: none [EE-225]")
    assert check(replace={old: new.replace(wrong, "none")}).exit_code == 0
    assert (
        check(replace={old: new.replace(wrong, "somewhere")}).exit_code == 2
    )  # near to nothing: refused as well


def test_a_default_that_no_wire_carries_is_refused_too(check: Check) -> None:
    result = check(replace={"codec: ees1-ascii ": "codec: legacy-nibble "})
    assert result.exit_code == 2
    found = [line.split(": ", 1)[1] for line in sentences(result)]
    what, todo = "legacy-nibble carries no", "if there is no such sensor, write"
    bits = "expected a bit of legacy-nibble: unlocked, locked, bottom, cylinder_extended, top"
    assert found == [
        f"{what} 'cylinder_retracted' (retracted_bit: cylinder_retracted (default)), {bits}; "
        f"{todo} retracted_bit: none [EE-225]",
        f"{what} 'cylinder' (cylinder), expected a codec with such a pressure; {todo} channel: none [EE-225]",
        f"{what} 'in_stand' (stand_bit: in_stand (default)), {bits}; {todo} stand_bit: none [EE-225]",
        f"{what} 'tool_present' (present_bit: tool_present (default)), {bits}; "
        f"{todo} present_bit: none [EE-225]",
        f"{what} 'supply' (channel: supply (default)), expected a codec with such a pressure; "
        f"{todo} channel: none [EE-225]",
    ]


def test_none_belongs_to_no_device(check: Check) -> None:
    bits = "extended_bit: none\n    retracted_bit: none"
    result = check(replace={"channel: cylinder\n": f"channel: cylinder\n    {bits}\n"})
    assert (result.exit_code, result.stderr) == (0, "")


def test_a_cylinder_is_not_confirmed_by_its_retracted_bit(check: Check) -> None:
    replace = {"channel: cylinder\n": "channel: none\n    extended_bit: none\n"}
    assert "ees1-ascii carries nothing that could confirm 'cylinder' (none)" in check(replace=replace).stderr


def test_an_unknown_codec_is_a_fault_at_its_place(check: Check) -> None:
    result = check(replace={"codec: ees1-ascii ": "codec: ees1-asci "})
    assert result.exit_code == 2
    assert sentences(result) == [
        "tool.yaml:13:10: there is no such codec (ees1-asci), expected one of ees1-ascii, "
        "ees1-cobs, legacy-nibble, modbus-rtu-epick, modbus-rtu-onrobot-vg, modbus-rtu-transmitters; "
        "did you mean 'ees1-ascii'? [EE-226]"
    ]


def test_an_actuator_that_nothing_can_confirm_is_a_fault(check: Check) -> None:
    result = check(replace={"channel: bottom": "channel: botom"})
    assert result.exit_code == 2
    assert sentences(result) == [
        "tool.yaml:22:14: ees1-ascii carries nothing that could confirm 'bottom_vacuum' (botom), "
        "expected a free channel of ees1-ascii: bottom; did you mean 'bottom'? [EE-225]"
    ]


def test_a_cylinder_may_be_confirmed_by_its_bit_alone(check: Check) -> None:
    replace = {"channel: cylinder": "channel: none"}
    result = check("--json", replace=replace)
    assert result.exit_code == 0
    assert json.loads(result.stdout)["not_fitted"] == [
        "cylinder: channel: none: only cylinder_extended confirms that it is extended, "
        "thresholds are off: lost air is not detected",
        NO_E_STOP,
    ]
    replace = {"channel: cylinder": "channel: none\n    extended_bit: ~\n    retracted_bit: ~"}
    assert "carries nothing that could confirm 'cylinder'" in check(replace=replace).stderr


ANOTHER = """\
  another:
    kind: {kind}
    line: SODIMM_214
    channel: {channel}
"""


@pytest.mark.parametrize(
    ("codec", "kind", "channel", "offered"),
    [
        ("ees1-ascii", "vacuum", "further", "expected another codec: ees1-ascii has no free channel for a vacuum"),
        ("legacy-nibble", "vacuum", "further", "another codec: legacy-nibble has no free channel for a vacuum"),
        ("modbus-rtu-transmitters", "cylinder", "further", "has no free channel for a cylinder [EE-225]"),
    ],
)  # fmt: skip
def test_only_channels_that_such_an_actuator_can_use_are_offered(
    check: Check, codec: str, kind: str, channel: str, offered: str
) -> None:
    stanza = ANOTHER.format(kind=kind, channel=channel)
    stanza += "    extended_bit: ~\n    retracted_bit: ~\n" if kind == "cylinder" else ""
    replace = {
        "codec: ees1-ascii ": f"codec: {codec} ",
        "cylinder, top_vacuum]": "cylinder, top_vacuum, another]",
        "\ntool_changer:": f"{stanza}\ntool_changer:",
    }
    assert offered in check(replace=replace).stderr


def test_a_fourth_actuator_on_the_channel_of_the_supply(check: Check) -> None:
    stanza = ANOTHER.format(kind="vacuum", channel="supply")
    replace = {
        "cylinder, top_vacuum]": "cylinder, top_vacuum, another]",
        "\ntool_changer:": f"{stanza}\ntool_changer:",
        "supply:\n  frozen_s: 2.0": "supply: {channel: none}",
    }
    result = check("--json", replace=replace)
    assert result.exit_code == 0, result.stdout
    assert "no sensor of the supply (channel: none): IL-06 is off" in result.stdout


def test_a_cylinder_is_offered_its_bit(check: Check) -> None:
    replace = {
        "codec: ees1-ascii ": "codec: legacy-nibble ",
        "channel: cylinder": "channel: top\n    extended_bit: ~\n    retracted_bit: ~",
        "channel: top\n    service": "channel: elsewhere\n    service",
    }
    said = check(replace=replace).stderr
    assert "'elsewhere'" not in said
    assert "carries nothing that could confirm 'top_vacuum' (elsewhere), expected another codec" in said
    replace["channel: cylinder"] = "channel: nowhere\n    extended_bit: ~\n    retracted_bit: ~"
    said = check(replace=replace).stderr
    assert "confirm 'cylinder' (nowhere), expected extended_bit: cylinder_extended [EE-225]" in said
    assert "confirm 'top_vacuum' (elsewhere), expected a free channel of legacy-nibble: top [EE-225]" in said


@pytest.mark.parametrize(
    ("replace", "said"),
    [
        (
            {"channel: bottom": "channel: locked"},
            "'locked' is a position bit and no pressure (locked), expected a free channel of ees1-ascii: bottom [",
        ),
        ({"  service: SetToolChanger": "  stand_bit: top"}, "'top' is a pressure (stand_bit: top), expected a bit"),
        ({"channel: top": "channel: tpo"}, "ees1-ascii carries nothing that could confirm 'top_vacuum' (tpo)"),
        (TRANSMITTERS, ""),
        (
            {"supply:\n  frozen_s: 2.0": "supply:\n  frozen_s: 0.05"},
            "5 samples take 0.1 s with ees1-ascii (0.05), expected at least 0.1, or null",
        ),
        ({"baudrate: 115200": "baudrate: 100"}, "'baudrate' is out of range (100), expected at least 300"),
    ],
)  # fmt: skip
def test_channels_and_codecs_that_do_not_fit(check: Check, replace: dict[str, str], said: str) -> None:
    result = check(replace=replace)
    assert said in result.stderr
    assert result.exit_code == (2 if said else 0)
    if not said:
        assert "counts too coarsely to show a frozen sensor: frozen_s is off" in result.stdout


def test_a_program_says_where_an_unknown_codec_stands(tmp_path: Path) -> None:
    text = profile_path().read_text().replace("codec: ees1-ascii ", "codec: ees1-cob ")
    (tmp_path / "tool.yaml").write_text(text)
    with pytest.raises(UsageError, match=r"tool\.yaml:13:10: .*Did you mean ees1-cobs\?"):
        codec_of(load(tmp_path / "tool.yaml"))
