"""``eehal check`` and ``eehal schema`` as they are used: output, exit codes."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli import _schema
from end_effector_hal.cli.check import _check
from end_effector_hal.codecs import codec_of
from end_effector_hal.description import load, markdown, profile_path, schema_text
from end_effector_hal.errors import UsageError
from tests.support.places import ROOT

SHIPPED = profile_path().read_text(encoding="utf-8")
Check = Callable[..., Result]

EXCERPT = re.compile(r" *\d* \|( |$)")


def sentences(result: Result) -> list[str]:
    """What is wrong, without the lines of the file and the marks below."""
    return [line for line in result.stderr.splitlines() if not EXCERPT.match(line)]


NO_E_STOP = "e-stop: none in the description: IL-13 is off"


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    """Runs the command on the shipped description with a text replaced in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def run(*options: str, replace: dict[str, str] | None = None) -> Result:
        text = SHIPPED
        for old, new in (replace or {}).items():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        Path("tool.yaml").write_text(text, encoding="utf-8")
        return CliRunner().invoke(_check.command, ["tool.yaml", *options], catch_exceptions=False)

    return run


def test_a_valid_description_is_told_in_short(check: Check) -> None:
    result = check()
    assert (result.exit_code, result.stderr) == (0, "")
    words = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert words[0].startswith("verdin_gripper multifunction end-effector on a Toradex Verdin")
    assert words[1:] == [
        "actuator kind line pin channel time-out reset gone",
        "bottom_vacuum vacuum SODIMM_208 X20 pin 28 bottom 3 x 5 s 1 s 2 s",
        "cylinder cylinder SODIMM_210 X20 pin 29 cylinder 3 x 5 s 1 s 2 s",
        "top_vacuum vacuum SODIMM_212 X20 pin 30 top 3 x 5 s 1 s 2 s",
        "changer SODIMM_206, X20 pin 27; locked or unlocked within 2 s; unlock at most 3 s",
        "lines gpiod",
        "link /dev/verdin-uart1, ees1-ascii, 115200 baud",
        f"automata {profile_path().with_name('end_effector.xml')}",
        f"not fitted {NO_E_STOP}",
    ]


NIBBLE = {
    "codec: ees1-ascii ": "codec: legacy-nibble ",
    "channel: cylinder\n": "channel: none\n    retracted_bit: none\n",
    "  service: SetToolChanger": "  stand_bit: none\n  present_bit: none",
    "supply:\n": "supply:\n  channel: none\n",
}
"""The shipped tool with the prototype's byte: what that does not carry is declared as none."""
TRANSMITTERS = {
    "codec: ees1-ascii ": "codec: modbus-rtu-transmitters ",
    "channel: cylinder\n": "channel: cylinder\n    extended_bit: none\n    retracted_bit: none\n",
    "  service: SetToolChanger": "  locked_bit: none\n  unlocked_bit: none\n  stand_bit: none\n  present_bit: none",
}


@pytest.mark.parametrize(
    ("codec", "baud", "replace"), [("ees1-ascii", 115_200, {}), ("legacy-nibble", 9_600, NIBBLE)]
)
def test_a_baud_rate_that_is_not_given_is_told_as_that_of_the_codec(
    check: Check, codec: str, baud: int, replace: dict[str, str]
) -> None:
    result = check(replace={"  baudrate: 115200\n": "", **replace})
    assert f"/dev/verdin-uart1, {codec}, {baud} baud\n" in result.stdout


def test_without_a_file_it_is_the_shipped_one() -> None:
    result = CliRunner().invoke(_check.command, ["--json"], catch_exceptions=False)
    assert result.exit_code == 0
    assert json.loads(result.stdout) == {
        "schema_version": 1,
        "ok": True,
        "exit_code": 0,
        "faults": [],
        "not_fitted": [NO_E_STOP],
        "warnings": [],
        "hints": [],
        "computed_bounds": {},
    }


def test_each_fault_is_a_line_on_stderr(check: Check) -> None:
    result = check(replace={"timeout_s: 5.0": "timeout_ms: 5000", "kind: cylinder": "kind: cylinderr"})
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.splitlines() == [
        "tool.yaml:25:5: wrong unit in key 'timeout_ms' (timeout_ms: 5000), expected seconds; "
        "write timeout_s: 5 [EE-210]",
        "   |",
        "25 |     timeout_ms: 5000",
        "   |     ^^^^^^^^^^",
        "tool.yaml:34:11: unknown kind of actuator (cylinderr), expected vacuum or cylinder or gripper or magnet; "
        "did you mean 'cylinder'? [EE-209]",
        "   |",
        "34 |     kind: cylinderr",
        "   |           ^^^^^^^^^",
    ]


def test_faults_as_json(check: Check) -> None:
    result = check("--json", replace={"timeout_s: 5.0": "timeout_s: 5000"})
    assert (result.exit_code, result.stderr) == (2, "")
    message = "'timeout_s' is out of range (5000), expected at least 0.001 and at most 600 s; "
    assert json.loads(result.stdout) == {
        "schema_version": 1,
        "ok": False,
        "exit_code": 2,
        "faults": [
            {
                "code": "EE-208",
                "file": "tool.yaml",
                "line": 25,
                "column": 16,
                "message": message + "milliseconds? write timeout_s: 5",
            }
        ],
        "not_fitted": [],
        "warnings": [],
        "hints": [],
        "computed_bounds": {},
    }


def test_bounds_that_are_not_written_are_told(check: Check) -> None:
    shorter = {"  grip_s: 58.0\n": "", "attempts: 3": "attempts: 2"}
    told = "bounds    computed, for they are not written: grip_s = 51.8\n"
    assert told in check(replace=shorter).stdout
    assert json.loads(check("--json", replace=shorter).stdout)["computed_bounds"] == {"grip_s": 51.8}


def test_what_cannot_be_proven_without_a_sensor_is_told(check: Check) -> None:
    result = check("--json", replace=NIBBLE)
    assert result.exit_code == 0
    assert json.loads(result.stdout)["not_fitted"] == [
        "bottom_vacuum: bottom is a switch, on or off, and no pressure: thresholds are off",
        "cylinder: channel: none: cylinder_extended alone proves extended, thresholds are off: "
        "that its air is lost is not seen",
        "cylinder: retracted_bit: none: retracted is taken as the opposite of extended: "
        "a rod that stops on its way is taken for retracted",
        "top_vacuum: top is a switch, on or off, and no pressure: thresholds are off",
        "supply: channel: none: IL-06 is off, 600 kPa is taken for it: a lack of air is not seen",
        "tool changer: stand_bit: none: an unlock is armed first (IL-02)",
        NO_E_STOP,
    ]
    assert check(replace=NIBBLE).stdout.count("not fitted  ") == 7


def test_pressures_alone_prove_less_as_well(check: Check) -> None:
    result = check("--json", replace=TRANSMITTERS | {"bounds:": "e_stop: {channel: none}\n\nbounds:"})
    assert result.exit_code == 0, result.stdout
    assert [each for each in json.loads(result.stdout)["not_fitted"] if "frozen_s" not in each] == [
        "cylinder: extended_bit: none: the pressure cylinder alone proves extended: a rod that is stuck is not seen",
        "cylinder: retracted_bit: none: the pressure cylinder alone proves retracted: "
        "a rod that is stuck is not seen",
        "tool changer: locked_bit: none, unlocked_bit: none: a lock cannot be proven: IL-04 and IL-05 are off",
        "tool changer: stand_bit: none: an unlock is armed first (IL-02)",
        "e_stop: channel: none: an open e-stop is not seen: IL-13 is off",
    ]


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
    [
        pytest.param(*each, id=each[2], marks=[pytest.mark.nightly] if each[2] in OTHERS else [])
        for each in KEYS
    ],
)
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
        "cylinder: channel: none: cylinder_extended alone proves extended, thresholds are off: "
        "that its air is lost is not seen",
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
        (
            "ees1-ascii",
            "vacuum",
            "further",
            "expected another codec: ees1-ascii carries nothing more for a vacuum",
        ),
        (
            "legacy-nibble",
            "vacuum",
            "further",
            "another codec: legacy-nibble carries nothing more for a vacuum",
        ),
        ("modbus-rtu-transmitters", "cylinder", "further", "carries nothing more for a cylinder [EE-225]"),
    ],
)
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
    assert "supply: channel: none: IL-06 is off" in result.stdout


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


def test_times_that_the_link_is_too_slow_for_are_told(check: Check) -> None:
    result = check("--json", replace=NIBBLE)
    told = json.loads(result.stdout)
    assert (told["ok"], result.exit_code) == (True, 0)
    too_early = "is over before a reading of legacy-nibble is stale (3 s, one each 1 s): a late or lost frame fails it"
    again = "is no longer than a period of legacy-nibble (1 s): what one attempt showed may confirm the next"
    names = ("bottom_vacuum", "cylinder", "top_vacuum")
    assert told["warnings"] == [
        *(f"{name}: release_s = 2 s {too_early}" for name in names),
        f"tool changer: prove_s = 2 s {too_early}",
        *(f"{name}: reset_s = 1 s {again}" for name in names),
    ]
    plain = check(replace=NIBBLE)
    assert plain.stdout.count("\nwarning  ") == 7
    enough = {"release_s: 2.0": "release_s: 3.1", "reset_s: 1.0": "reset_s: 1.1"}
    result = check("--json", replace=enough | NIBBLE)
    assert [each for each in json.loads(result.stdout)["warnings"] if each.startswith("bottom_vacuum")] == []
    slow = json.loads(check("--json", replace={"baudrate: 115200": "stale_s: 2.5\n  down_s: 3"}).stdout)
    assert "tool changer: prove_s = 2 s is over before" in slow["warnings"][-1]


def test_samples_that_take_longer_than_the_time_out_can_never_confirm(check: Check) -> None:
    slow = NIBBLE | {"lost_kpa: 50.0": "confirmed_samples: 6"}
    result = check(replace=slow)
    assert result.exit_code == 2
    assert sentences(result) == [
        "tool.yaml:31:24: 'bottom_vacuum' can never be confirmed: 6 samples take 5 s (legacy-nibble), "
        "expected less than timeout_s = 5 [EE-225]"
    ]
    assert check(replace=slow | {"lost_kpa: 50.0": "confirmed_samples: 5"}).exit_code == 0


def test_what_is_switched_off_is_told(check: Check) -> None:
    result = check(replace={"bounds:": "interlocks: {IL-05: false, IL-06: false}\nbounds:"})
    assert "switched off  IL-05, IL-06\n" in result.stdout


def test_words_of_the_user_are_not_markup(check: Check) -> None:
    result = check(replace={"summary: multifunction": "summary: '[bold]x[/bold] :smile:' #"})
    assert result.stdout.startswith("verdin_gripper  [bold]x[/bold] :smile: (")


def test_a_description_without_a_tool_changer(check: Check) -> None:
    stanza = SHIPPED[SHIPPED.index("tool_changer:") : SHIPPED.index("bounds:")]
    result = check("--json", replace={stanza: ""})
    assert result.exit_code == 0
    assert json.loads(result.stdout)["not_fitted"] == [
        "tool changer: none in the description: IL-01 to IL-05 are off",
        NO_E_STOP,
    ]


@pytest.mark.parametrize(
    ("old", "new"),
    [("</nta>", ""), ("ATTEMPTS[i]", "ATTEMPTZ[i]"), ("<template>", "<tmplate>")],
    ids=["cut off", "unknown name", "unknown element"],
)
def test_broken_automata_are_found(check: Check, tmp_path: Path, old: str, new: str) -> None:
    text = profile_path().with_name("end_effector.xml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "end_effector.xml").write_text(text.replace(old, new, 1), encoding="utf-8")
    result = check()
    assert (result.exit_code, result.stdout) == (2, "")
    assert "Traceback" not in result.stderr
    assert result.stderr.startswith(str(tmp_path / "end_effector.xml") + ":")
    (said,) = sentences(result)
    assert said.endswith("[EE-300]")
    fault = json.loads(check("--json").stdout)["faults"][0]
    assert (fault["code"], fault["file"]) == ("EE-300", str(tmp_path / "end_effector.xml"))
    assert fault["line"] > 0


def test_automata_without_a_constant_of_the_description(check: Check, tmp_path: Path) -> None:
    text = profile_path().with_name("end_effector.xml").read_text(encoding="utf-8")
    own = tmp_path / "end_effector.xml"
    own.write_text(text.replace("ATTEMPTS", "TRIES"), encoding="utf-8")
    result = check()
    assert result.exit_code == 2
    assert result.stderr.startswith(f"{own}: declares no global constant 'ATTEMPTS'.")


def test_a_process_that_the_automata_do_not_have_is_found(check: Check) -> None:
    result = check(replace={"bounds:": "automata: {grip: [Griper, Actuator]}\nbounds:"})
    assert result.exit_code == 2
    line = SHIPPED[: SHIPPED.index("bounds:")].count("\n") + 1
    assert result.stderr.startswith(f"tool.yaml:{line}:11: ")
    assert "Griper" in result.stderr
    assert "Gripper" in result.stderr


def test_a_file_that_is_missing() -> None:
    result = CliRunner().invoke(_check.command, ["/nowhere/tool.yaml"])
    assert result.exit_code == 2
    assert sentences(result) == [
        "/nowhere/tool.yaml: there is no such file, expected the path of a description [EE-201]"
    ]


def test_schema_for_editors_and_tables_for_people() -> None:
    assert CliRunner().invoke(_schema.command).stdout == schema_text()
    assert CliRunner().invoke(_schema.command, ["--markdown"]).stdout == markdown()


@pytest.mark.parametrize(
    ("replace", "said"),
    [
        (
            {"channel: bottom": "channel: locked"},
            "'locked' is a position bit and no pressure (locked), expected a free channel of ees1-ascii: bottom [",
        ),
        (
            {"  service: SetToolChanger": "  stand_bit: top"},
            "'top' is a pressure (stand_bit: top), expected a bit",
        ),
        (
            {"channel: top": "channel: tpo"},
            "ees1-ascii carries nothing that could confirm 'top_vacuum' (tpo)",
        ),
        (
            TRANSMITTERS,
            "",
        ),
        (
            {"supply:\n  frozen_s: 2.0": "supply:\n  frozen_s: 0.05"},
            "5 samples take 0.1 s with ees1-ascii (0.05), expected at least 0.1, or null",
        ),
        ({"baudrate: 115200": "baudrate: 100"}, "'baudrate' is out of range (100), expected at least 300"),
    ],
)
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


def test_how_an_earlier_description_is_said_the_new_way(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    text = "schema: 1\n" + profile_path().read_text("utf-8")
    path.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(_check.command, [str(path)], catch_exceptions=False)
    assert result.exit_code == 0
    assert f"hint  {path}:1:9: write schema: 2; all that stands here keeps its meaning" in result.output
    path.write_text(text.replace("schema: 1", "schema: 2"), encoding="utf-8")
    assert "hint" not in CliRunner().invoke(_check.command, [str(path)], catch_exceptions=False).output


def test_each_wire_of_an_output_is_in_the_table() -> None:
    tools = Path("examples/tools")
    for folder, rows in (
        ("bistable_and_magnet", ("second coil",)),
        ("diy_vacuum", ("blow-off",)),
    ):
        path = tools / folder / "end_effector.yaml"
        shown = CliRunner().invoke(_check.command, [str(path)], catch_exceptions=False).stdout
        tool = load(path)
        lines = [*(each.line for each in tool.opposites.values()), *tool.blow_off_lines.values()]
        found = [row.split() for row in shown.splitlines() if row.strip().startswith(rows)]
        assert lines
        assert sorted(word for row in found for word in row if word in lines) == sorted(lines)


def test_the_number_of_a_register_in_a_manual_is_told(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(
        "schema: 2\nname: tool\nlink: {port: x, frame: {modbus: {}}}\n"
        "channels: {p: {modbus: {address: 40003}, unit: kPa}}\n"
        "sequence: [a]\nactuators: {a: {kind: vacuum, line: A, channel: p}}\nsupply: {channel: none}\n"
    )
    assert _check.check(path).hints == (
        f"{path}:4:34: is 40003 the number in a manual? On the wire that is address: 2, register_type: holding",
    )


def test_a_frame_without_a_checksum_and_a_channel_that_nothing_uses_are_told(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    frame = "link: {port: x, period_ms: 20, frame: {text: {separator: ';'%s}}}\n"
    rest = (
        "channels: {p: {text: {key: A}, unit: kPa}, q: {text: {key: B}, unit: kPa}}\n"
        "sequence: [a]\nactuators: {a: {kind: vacuum, line: A, channel: p}}\nsupply: {channel: none}\n"
    )
    path.write_text("schema: 2\nname: tool\n" + frame % "" + rest)
    unchecked, unused = _check.check(path).hints
    assert unchecked.startswith(f"{path}:3:")
    assert "without a checksum" in unchecked
    assert unused.startswith(f"{path}:4:")
    assert unused.endswith("nothing uses the channel q")
    path.write_text("schema: 2\nname: tool\n" + frame % ", checksum: xor8" + rest)
    assert _check.check(path).hints == (unused,)


@pytest.mark.parametrize("key", ["timeout_s: 5.0", "release_s: 2.0", "reset_s: 1.0"])
def test_a_time_below_the_units_of_the_model_is_refused(check: Check, key: str) -> None:
    result = check(replace={key: f"{key.split(':')[0]}: 1e-300"})
    assert result.exit_code == 2
    assert "is out of range (1e-300), expected at least 0.001 and at most 600 s" in result.stderr


def test_a_sequence_of_numbers_is_not_called_empty(check: Check) -> None:
    result = check(replace={"sequence: [bottom_vacuum, cylinder, top_vacuum]": "sequence: [1, 2]"})
    assert result.exit_code == 2
    assert "'sequence[0]' is of the wrong type (1), expected text" in result.stderr
    assert "is empty" not in result.stderr


def test_what_a_commanded_device_reports_of_itself_is_used() -> None:
    for tool in ("epick_commanded", "gripper_2f85"):
        assert _check.check(ROOT / "examples" / "tools" / tool / "end_effector.yaml").hints == ()


def test_a_threshold_that_alarms_and_the_page_do_not_show_is_told(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    text = (
        "schema: 2\nname: tool\nlink: {port: x, frame: {text: {checksum: xor8}}}\n"
        "channels: {p: {text: {field: 1}, unit: kPa}}\nsequence: [a]\n"
        "actuators: {a: {kind: vacuum, line: A, channel: p, gone_kpa: %s}}\nsupply: {channel: none}\n"
    )
    path.write_text(text % 9.5)
    assert _check.check(path).hints == ()
    path.write_text(text % 9.95)
    (said,) = _check.check(path).hints
    assert said.startswith(f"{path}:6:")
    assert "a threshold finer than 0.1 kPa" in said
