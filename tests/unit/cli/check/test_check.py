"""``eehal check`` and ``eehal schema`` as they are used: output, exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli import _check
from end_effector_hal.cli._completion import schema
from end_effector_hal.description import SHIPPED_AUTOMATA, load, markdown, schema_text
from tests.unit.cli.check.conftest import NIBBLE, NO_E_STOP, SHIPPED, TRANSMITTERS, Check, sentences


def test_a_valid_description_is_told_in_short(check: Check) -> None:
    result = check()
    assert (result.exit_code, result.stderr) == (0, "")
    words = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert words[0].startswith("verdin_gripper multifunction end-effector on a Toradex Verdin")
    assert words[1:] == [
        "actuator kind line pin channel time-out reset release",
        "bottom_vacuum vacuum SODIMM_208 X20 pin 28 bottom 3 x 5 s 1 s 2 s",
        "cylinder cylinder SODIMM_210 X20 pin 29 cylinder 3 x 5 s 1 s 2 s",
        "top_vacuum vacuum SODIMM_212 X20 pin 30 top 3 x 5 s 1 s 2 s",
        "changer SODIMM_206, X20 pin 27; locked or unlocked within 2 s; unlock at most 3 s",
        "lines gpiod",
        "link /dev/verdin-uart1, ees1-ascii, 115200 baud",
        f"automata {SHIPPED_AUTOMATA}",
        f"not fitted {NO_E_STOP}",
    ]


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
        "devices": [],
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


@pytest.mark.parametrize(
    ("written", "shown"),
    [(b"a\xff\x01", r"a\xff\x01"), (b"a\x1b[31m", r"a\x1b[31m"), ("a\u202e".encode(), r"a\u202e")],
)
def test_what_cannot_be_printed_is_shown_escaped(
    written: bytes, shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tool.yaml").write_bytes(b"sequence: " + written + b"\n")
    found = CliRunner().invoke(_check.command, ["tool.yaml"], catch_exceptions=False).stderr
    assert f"\n1 | sequence: {shown}\n" in found
    assert all(each.isprintable() for each in found.splitlines())


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
        "devices": [],
        "computed_bounds": {},
    }


def test_bounds_that_are_not_written_are_told(check: Check) -> None:
    shorter = {"  grip_s: 58.0\n": "", "attempts: 3": "attempts: 2"}
    told = "bounds    computed from times and attempts, for lack of `bounds:`: grip_s = 51.8\n"
    assert told in check(replace=shorter).stdout
    assert json.loads(check("--json", replace=shorter).stdout)["computed_bounds"] == {"grip_s": 51.8}


def test_what_cannot_be_proven_without_a_sensor_is_told(check: Check) -> None:
    result = check("--json", replace=NIBBLE)
    assert result.exit_code == 0
    assert json.loads(result.stdout)["not_fitted"] == [
        "bottom_vacuum: bottom is a switch, on or off, and no pressure: thresholds are off",
        "cylinder: channel: none: only cylinder_extended confirms that it is extended, "
        "thresholds are off: lost air is not detected",
        "cylinder: retracted_bit: none: retracted is assumed to be the opposite of extended: "
        "a rod that stops on its way counts as retracted",
        "top_vacuum: top is a switch, on or off, and no pressure: thresholds are off",
        "no sensor of the supply (channel: none): IL-06 is off: 600 kPa is assumed, and low pressure is not detected",
        "tool changer: stand_bit: none: an unlock is armed first (IL-02)",
        NO_E_STOP,
    ]
    assert check(replace=NIBBLE).stdout.count("not fitted  ") == 7


def test_pressures_alone_prove_less_as_well(check: Check) -> None:
    result = check("--json", replace=TRANSMITTERS | {"bounds:": "e_stop: {channel: none}\n\nbounds:"})
    assert result.exit_code == 0, result.stdout
    assert [each for each in json.loads(result.stdout)["not_fitted"] if "frozen_s" not in each] == [
        "cylinder: extended_bit: none: only the pressure cylinder confirms that it is extended: "
        "a stuck rod is not detected",
        "cylinder: retracted_bit: none: only the pressure cylinder confirms that it is retracted: "
        "a stuck rod is not detected",
        "tool changer: locked_bit: none, unlocked_bit: none: a lock cannot be proven: IL-04 and IL-05 are off",
        "tool changer: stand_bit: none: an unlock is armed first (IL-02)",
        "e_stop: channel: none: an open e-stop is not seen: IL-13 covers only the software stop",
    ]


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
        "no tool changer in the description: IL-01 to IL-05 are off",
        NO_E_STOP,
    ]


def test_a_file_that_is_missing() -> None:
    result = CliRunner().invoke(_check.command, ["/nowhere/tool.yaml"])
    assert result.exit_code == 2
    assert sentences(result) == [
        "/nowhere/tool.yaml: there is no such file, expected the path of a description [EE-201]"
    ]


def test_schema_for_editors_and_tables_for_people() -> None:
    assert CliRunner().invoke(schema).stdout == schema_text()
    assert CliRunner().invoke(schema, ["--markdown"]).stdout == markdown()


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


@pytest.mark.parametrize(
    ("old", "new"),
    [("</nta>", ""), ("ATTEMPTS[part]", "ATTEMPTZ[part]"), ("<template>", "<tmplate>")],
    ids=["cut off", "unknown name", "unknown element"],
)
def test_broken_automata_are_found(check: Check, tmp_path: Path, old: str, new: str) -> None:
    text = SHIPPED_AUTOMATA.read_text(encoding="utf-8")
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
    text = SHIPPED_AUTOMATA.read_text(encoding="utf-8")
    own = tmp_path / "end_effector.xml"
    own.write_text(text.replace("ATTEMPTS", "TRIES"), encoding="utf-8")
    result = check()
    assert result.exit_code == 2
    assert result.stderr.startswith(f"{own}: declares no global constant 'ATTEMPTS'.")


def test_a_process_that_the_automata_do_not_have_is_found(check: Check) -> None:
    result = check(replace={"bounds:": "automata: {executed: [Griper, Actuator]}\nbounds:"})
    assert result.exit_code == 2
    line = SHIPPED[: SHIPPED.index("bounds:")].count("\n") + 1
    assert result.stderr.startswith(f"tool.yaml:{line}:11: ")
    assert "Griper" in result.stderr
    assert "Gripper" in result.stderr


@pytest.mark.parametrize("key", ["timeout_s: 5.0", "release_s: 2.0", "reset_s: 1.0"])
def test_a_time_below_the_units_of_the_model_is_refused(check: Check, key: str) -> None:
    result = check(replace={key: f"{key.split(':')[0]}: 1e-300"})
    assert result.exit_code == 2
    assert "is out of range (1e-300), expected at least 0.001 and at most 600 s" in result.stderr
