"""``eehal model`` as it is used: output, files, exit codes, and sentences instead of tracebacks."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli.model._model import command
from end_effector_hal.description import SHIPPED_AUTOMATA, profile_path
from end_effector_hal.recording import read_run, read_states
from tests.unit.conftest import Whole

SHIPPED = profile_path()
AUTOMATA = SHIPPED_AUTOMATA
LAMP = """<nta><declaration>clock x; broadcast chan press, ring; const bool LOUD = true;</declaration>
<template><name>Lamp</name><location id="a" x="0" y="0"><name>Off</name></location>
<location id="b" x="100" y="0"><name>On</name><label kind="invariant">x &lt;= 9</label></location><init ref="a"/>
<transition><source ref="a"/><target ref="b"/><label kind="guard">LOUD</label>
<label kind="synchronisation">press!</label><label kind="assignment">x = 0</label></transition>
<transition><source ref="b"/><target ref="a"/><label kind="guard">x &gt;= 3</label></transition></template>
<system>system Lamp;</system><queries><query><formula>A[] x &gt;= 0</formula><comment>Time passes.</comment></query>
</queries></nta>"""


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("lamp.xml").write_text(LAMP, encoding="utf-8")


def run(*words: str) -> Result:
    return CliRunner().invoke(command, list(words), catch_exceptions=False)


def edited(name: str, **replace: str) -> Path:
    """The shipped description with other values, beside this test; it names the shipped automata."""
    text = SHIPPED.read_text(encoding="utf-8")
    for old, new in replace.items():
        text, count = re.subn(rf"(\b{old}: )\S+", rf"\g<1>{new}", text)
        assert count, old
    path = Path(name)
    path.write_text(text, encoding="utf-8")
    path.with_name("end_effector.xml").write_bytes(AUTOMATA.read_bytes())
    return path


# check -------------------------------------------------------------------------------------------------------


def test_a_valid_file_is_told() -> None:
    result = run("check", "lamp.xml")
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.splitlines() == [
        "lamp.xml is valid: 1 processes, 2 locations, 2 edges",
        "automata   lamp.xml",
        "processes  Lamp",
        "clocks     x",
        "channel    press  broadcast: Lamp → nobody",
        "channel    ring   broadcast: nobody → nobody",
        "note       nobody receives press",
        "note       nobody sends ring",
        "note       nobody receives ring",
        "query      A[] x >= 0   Time passes.",
    ]


def test_a_description_is_checked_with_its_constants() -> None:
    result = run("check", "--json")
    assert result.exit_code == 0
    answer = json.loads(result.stdout)
    assert answer["ok"]
    assert [process["name"] for process in answer["processes"][:4]] == [
        "Gripper", "Actuator(0)", "Actuator(1)", "Actuator(2)",
    ]  # fmt: skip
    assert "t" in answer["clocks"]
    (confirmed,) = [each for each in answer["channels"] if each["name"] == "confirmed[3]"]
    assert (confirmed["senders"], confirmed["receivers"]) == (["Sensors"], ["Gripper", "Actuator"])
    (deadlock,) = [each for each in answer["queries"] if each["query"] == "A[] not deadlock"]
    assert "deadlock" in deadlock["sentence"]


def test_every_fault_is_a_line_with_its_place() -> None:
    text = LAMP.replace("press!", "prezz!").replace("x = 0<", "y = 0<").replace("A[] x", "A[] z")
    Path("bad.xml").write_text(text, encoding="utf-8")
    result = run("check", "bad.xml")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.splitlines() == [
        "bad.xml:5:31: 'prezz' is not declared. Did you mean 'press'? [EE-300]",
        "bad.xml:5:70: 'y' is not declared. [EE-300]",
        "bad.xml:7:59: 'z' is not declared. [EE-300]",
    ]
    answer = json.loads(run("check", "bad.xml", "--json").stdout)
    assert (answer["ok"], len(answer["faults"])) == (False, 3)
    assert answer["faults"][0] == {
        "code": "EE-300",
        "file": "bad.xml",
        "line": 5,
        "column": 31,
        "message": "'prezz' is not declared. Did you mean 'press'?",
    }


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("Pr[&lt;=9](&lt;&gt; Lamp.On)", "'Pr[<=9](<> Lamp.On)', a query of statistical model checking"),
        ("A[] z", "'z' is not declared."),
    ],
)
def test_a_query_that_cannot_be_asked_leaves_the_rest_told(query: str, message: str) -> None:
    more = (
        f"<query><formula>{query}</formula></query><query><formula>// only a note</formula></query></queries>"
    )
    Path("bad.xml").write_text(LAMP.replace("</queries>", more), encoding="utf-8")
    result = run("check", "bad.xml")
    assert result.exit_code == 4
    assert result.stdout.startswith("bad.xml is valid: 1 processes, 2 locations, 2 edges\n")
    assert "query      A[] x >= 0   Time passes.\n" in result.stdout
    assert "only a note" not in result.stdout
    fault, count = result.stderr.splitlines()
    assert re.match(r"bad\.xml:8:\d+: ", fault)
    assert message in fault
    assert count == "1 of 2 queries cannot be asked."
    answer = json.loads(run("check", "bad.xml", "--json").stdout)
    assert (answer["ok"], answer["exit_code"], len(answer["faults"]), len(answer["queries"])) == (
        False, 4, 1, 2,
    )  # fmt: skip
    assert answer["clocks"] == ["x"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "The file is empty|no element found"),
        (b"<nta>", "no element found|not well-formed"),
        (b"\x00\xff", "not well-formed"),
        (b"<html/>", "not a UPPAAL model"),
    ],
)
def test_what_is_no_uppaal_file(content: bytes, message: str) -> None:
    Path("bad.xml").write_bytes(content)
    result = run("check", "bad.xml")
    assert result.exit_code == 2
    assert re.search(message, result.stderr)
    assert result.stderr.startswith("bad.xml:1:")


def test_faults_of_a_description_are_told_as_such() -> None:
    edited("tool.yaml", timeout_s="soon")
    result = run("check", "tool.yaml")
    assert result.exit_code == 2
    assert result.stderr.startswith("tool.yaml:")
    answer = json.loads(run("check", "tool.yaml", "--json").stdout)
    assert not answer["ok"]
    assert len(answer["faults"]) == len(result.stderr.splitlines())


def test_a_file_without_a_suffix_is_known_by_its_first_letter() -> None:
    Path("model").write_text("\n " + LAMP.replace("press!", "prezz!"), encoding="utf-8")
    assert "model:6:31: 'prezz'" in run("check", "model").stderr
    assert run("check", "missing").exit_code == 2
    assert (
        run("check", "missing.xml").stderr
        == "missing.xml: The file cannot be read: No such file or directory. [EE-300]\n"
    )


# show --------------------------------------------------------------------------------------------------------


def test_a_template_is_drawn_with_the_constants_of_the_description() -> None:
    edited("tool.yaml", timeout_s="7.5")
    assert run("show", "tool.yaml", "--template", "Gripper", "-o", "drawings").exit_code == 0
    svg = Path("drawings/Gripper.svg").read_text(encoding="utf-8")
    assert "T_CONFIRM = {{7500, 5000, 5000}}" in svg
    assert "CANCEL_KEEPS = {false, false, false}" in svg
    assert "STAND_BY =" not in svg  # Table II is no matter of the description


@pytest.mark.thinned  # long
def test_each_template_is_drawn() -> None:
    result = run("show", "-o", "drawings")
    assert result.exit_code == 0
    names = [line.split(":")[0] for line in result.stdout.splitlines()]
    assert names == [
        "Gripper", "Actuator", "Changer", "Arming", "World", "Sensors", "Tool", "Observer", "Listener",
        "Patience", "Commands", "Arbiter", "UnlockLine", "Blower", "Wills",
    ]  # fmt: skip
    assert sorted(path.name for path in Path("drawings").iterdir()) == sorted(
        f"{name}.{suffix}" for name in names for suffix in ("png", "svg")
    )


def test_any_uppaal_file_is_drawn() -> None:
    answer = json.loads(run("show", "--model", "lamp.xml", "-o", "out", "--json").stdout)
    assert answer == {
        "schema_version": 1,
        "source": "lamp.xml",
        "templates": {"Lamp": ["out/Lamp.png", "out/Lamp.svg"]},
    }
    assert "LOUD = true" in Path("out/Lamp.svg").read_text(encoding="utf-8")
    ET.parse("out/Lamp.svg")


def test_no_template_overwrites_another() -> None:
    template = LAMP[LAMP.index("<template>") : LAMP.index("</template>") + 11]
    second = re.sub('="([ab])"', r'="second_\1"', template.replace("Lamp", "lamp"))
    Path("two.xml").write_text(LAMP.replace(template, template + second), encoding="utf-8")
    assert run("show", "--model", "two.xml", "-o", "out").exit_code == 0
    assert sorted(path.name for path in Path("out").glob("*.svg")) == ["Lamp.svg", "lamp_.svg"]


# export ------------------------------------------------------------------------------------------------------


def test_with_its_own_constants_the_shipped_file_is_exported_unchanged() -> None:
    result = run("export")
    assert result.exit_code == 0
    assert result.stdout_bytes == AUTOMATA.read_bytes()
    assert run("export", str(SHIPPED), "-o", "out.xml").stdout == "out.xml\n"
    assert Path("out.xml").read_bytes() == AUTOMATA.read_bytes()


def test_the_constants_of_another_description_are_put_in() -> None:
    edited("tool.yaml", timeout_s="7.5", reaction_ms="20")
    assert run("export", "tool.yaml", "-o", "out.xml").exit_code == 0
    old, new = (
        AUTOMATA.read_text(encoding="utf-8").splitlines(),
        Path("out.xml").read_text(encoding="utf-8").splitlines(),
    )
    changed = [
        after.split("//")[0].rstrip() for before, after in zip(old, new, strict=True) if before != after
    ]
    assert changed == ["const int T_CONFIRM[PARTS][N] = {{7500, 5000, 5000}};", "const int D = 20;"]
    # what was written is a model, and a fixed point
    assert run("check", "out.xml").exit_code == 0
    assert run("export", "tool.yaml").stdout_bytes == Path("out.xml").read_bytes()


# simulate ----------------------------------------------------------------------------------------------------

GUIDED = "world == IN_TIME; adopt; grip @ 1000; confirmed[0] + 350; confirmed[1] + 400; confirmed[2] + 250"


def test_a_guided_run_is_told_line_by_line() -> None:
    result = run("simulate", "--model", "lamp.xml", "--choose", "press @ 5; Lamp.Off; press + 2.5")
    assert result.stdout.splitlines() == [
        "   5 ms  press: Lamp Off → On",
        "   8 ms  Lamp On → Off",
        "10.5 ms  press: Lamp Off → On",
        "10.5 ms  The run ends here.",
    ]


def test_it_leaves_a_recording_with_its_figure() -> None:
    result = run("simulate", "--choose", GUIDED, "-o", "out")
    assert result.exit_code == 0
    assert result.stdout.splitlines()[-6:] == [
        f"out/{name}"
        for name in ("run.txt", "states.csv", "events.csv", "run.json", "timeline.png", "timeline.svg")
    ]
    log = read_states("out/states.csv")
    assert log.actuators == ("bottom_vacuum", "cylinder", "top_vacuum")
    assert [(row.time_s, row.end_effector.name) for row in log.rows][-1] == (2.0, "GRIPPED")
    info = read_run("out")
    assert (info.scenario, info.description, info.simulated) == (
        "run of the model, seed 0",
        "verdin_gripper",
        True,
    )
    assert Path("out/run.txt").read_text(encoding="utf-8").splitlines() == result.stdout.splitlines()[:-6]
    # another run replaces it
    run("simulate", "--choose", "world == IN_TIME; adopt", "-o", "out")
    assert len(read_states("out/states.csv").rows) == 2


def test_the_same_seed_is_the_same_run_and_the_same_bytes() -> None:
    first, again = (run("simulate", "--seed", "7", "--for", "30", "-o", name) for name in ("a", "b"))
    assert first.exit_code == 0
    assert first.stdout.replace("a/", "b/") == again.stdout
    for name in ("run.txt", "states.csv", "run.json", "timeline.png", "timeline.svg"):
        assert Path("a", name).read_bytes() == Path("b", name).read_bytes()
    assert run("simulate", "--seed", "8", "--for", "30").stdout not in first.stdout


def test_as_json() -> None:
    answer = json.loads(run("simulate", "--model", "lamp.xml", "--choose", "press @ 5", "--json").stdout)
    assert answer == {
        "schema_version": 1,
        "source": "lamp.xml",
        "seed": 0,
        "steps": [
            {
                "at_ms": 5.0,
                "channel": "press",
                "edges": [{"process": "Lamp", "source": "Off", "target": "On", "selected": {}}],
                "changes": {},
                "words": {},
            }
        ],
        "end_ms": 5.0,
        "remark": "The run ends here.",
        "files": [],
        "notes": [],
    }


def test_a_model_of_something_else_has_no_figure() -> None:
    result = run("simulate", "--model", "lamp.xml", "--steps", "3", "-o", "out")
    assert result.exit_code == 0
    assert [path.name for path in Path("out").iterdir()] == ["run.txt"]
    assert "Note: The model has no variables ee, command and actuator[]" in result.stderr


def test_a_model_without_a_description_has_one_with_the_names_of_its_variables() -> None:
    result = run("simulate", "--model", str(AUTOMATA), "--choose", GUIDED, "-o", "out")
    assert result.exit_code == 0
    assert read_states("out/states.csv").actuators == ("actuator_0", "actuator_1", "actuator_2")


def test_a_value_out_of_range_is_an_error_with_the_run_that_leads_to_it() -> None:
    text = LAMP.replace("clock x;", "clock x; int[0,1] v;").replace("x = 0<", "x = 0, v++<")
    Path("range.xml").write_text(text, encoding="utf-8")
    result = run("simulate", "--model", "range.xml", "--steps", "9")
    assert result.exit_code == 2
    assert len(result.stdout.splitlines()) == 3
    assert result.stderr.startswith("range.xml:5:")


# Bad input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["show", "missing.yaml"], "missing.yaml"),
        (["show", "--model", "missing.xml"], "missing.xml: The file cannot be read"),
        (["show", "lamp.xml"], "This is a UPPAAL file, not a description. Write '--model lamp.xml'."),
        (["export", "lamp.xml"], "This is a UPPAAL file, not a description."),
        (["simulate", "tool.yaml", "--model", "lamp.xml"], "A description and a model are named."),
        (["show", "--model", "lamp.xml", "-o", "lamp.xml"], "The folder cannot be made"),
        (["export", "-o", "no/such/folder/out.xml"], "The file cannot be written: No such file or directory."),
        (["simulate", "--model", "lamp.xml", "-o", "lamp.xml/x"], "The folder cannot be made"),
        (["simulate", "--model", "lamp.xml", "--choose", "ring"], "Choice 1, 'ring', is not possible after 0 steps"),
        (["simulate", "--model", "lamp.xml", "--choose", "Lamp.Onn"], "Did you mean 'On'?"),
        (["simulate", "--steps", "-1"], "Invalid value for '--steps'"),
        (["simulate", "--for", "nan"], "--for nan is no length of time"),
        (["simulate", "--for", "inf"], "Invalid value for '--for'"),
        (["simulate", "--seed", "x"], "Invalid value for '--seed'"),
        (["dance"], "No such command 'dance'"),
    ],
)  # fmt: skip
def test_bad_input_is_a_sentence_and_exit_code_2(whole: Whole, words: list[str], message: str) -> None:
    code, _, stderr = whole("model", *words)
    assert code == 2
    assert message in " ".join(stderr.split())
