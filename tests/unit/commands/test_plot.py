"""eehal plot: figures beside the recording, errors as sentences with exit code 2."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import partial

import pytest
from click.testing import CliRunner

from end_effector_hal.recording._pressures import PressuresWriter
from end_effector_lab.commands._testbench import command
from end_effector_lab.testbench import FAULTS
from tests.support.trace_recordings import FAILS_ONCE, NEVER, PRESSURES, written


@pytest.fixture
def run(tmp_path):
    """A run folder."""
    folder = written(tmp_path / "never", NEVER)
    with PressuresWriter(folder / "pressures.csv", PRESSURES.channels) as writer:
        for time_s, values in PRESSURES.samples:
            writer.write(time_s, dict(zip(PRESSURES.channels, values, strict=True)))
    return folder


@pytest.fixture
def plot(whole):
    """Runs the command; returns its exit code, output and error output."""
    return partial(whole, "plot")


def made(folder):
    return sorted(file.name for file in folder.iterdir() if file.suffix in (".png", ".svg"))


@pytest.mark.parametrize("where", ["states.csv", "."])
def test_a_file_or_a_folder_gives_the_timeline_beside_it(plot, run, where):
    code, out, err = plot(run / where)
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "Cylinder never confirmed: grip ABORTED after 3 attempts, released in reverse order",
        str(run / "timeline.png"),
        str(run / "timeline.svg"),
    ]
    assert made(run) == ["timeline.png", "timeline.svg"]
    svg = (run / "timeline.svg").read_text()
    assert "scenario never-confirms:cylinder" in svg
    assert "confirmed ≤ −55" in svg


def test_both_styles(plot, run):
    assert plot(run, "--style", "both")[0] == 0
    assert made(run) == ["paper.png", "paper.svg", "timeline.png", "timeline.svg"]


def test_one_file(plot, run, tmp_path):
    assert plot(run, "--style", "paper", "-o", tmp_path / "fig9.svg")[0] == 0
    assert made(tmp_path) == ["fig9.svg"]
    assert "HAL command" in (tmp_path / "fig9.svg").read_text()
    assert made(run) == []


def test_another_folder_is_made(plot, run, tmp_path):
    assert plot(run, "-o", tmp_path / "out" / "figures")[0] == 0
    assert made(tmp_path / "out" / "figures") == ["timeline.png", "timeline.svg"]


def test_json(plot, run):
    code, out, _ = plot(run, "--json", "-o", run / "a.png")
    answer = json.loads(out)
    assert code == 0
    assert answer["verdict"].startswith("Cylinder never confirmed")
    assert answer["files"] == [str(run / "a.png")]
    assert answer["final"] == "STAND_BY"
    assert answer["notes"] == []
    (grip,) = answer["grips"]
    assert (grip["decision"], grip["culprit"]) == ("ABORTED", "cylinder")
    assert [(a["actuator"], a["number"], a["of"], a["outcome"]) for a in grip["attempts"][1:]] == [
        ("cylinder", number, 3, "timed out") for number in (1, 2, 3)
    ]
    assert answer["releases"][0]["ended"] == "STAND_BY"


def test_the_states_alone_are_enough(plot, run):
    (run / "run.json").unlink()
    (run / "pressures.csv").unlink()
    assert plot(run)[0] == 0
    assert "no run.json: source unknown" in (run / "timeline.svg").read_text()


def test_what_is_cut_off_or_damaged_is_noted_and_the_rest_drawn(plot, run):
    with (run / "states.csv").open("a") as file:
        file.write("20.0,6,")
    (run / "pressures.csv").write_text("time_s,bottom_gauge_kpa\nx,y\n")
    (run / "run.json").write_text("{")
    code, _, err = plot(run)
    assert code == 0
    assert err.splitlines() == [
        f"Note: {run}/states.csv:13: the last line is cut off and was dropped.",
        f"Note: {run}/run.json can only be read in part: not JSON: Expecting property name "
        "enclosed in double quotes: line 1 column 2 (char 1).",
        f"Note: {run}/pressures.csv:2: time_s is 'x', expected is a number. The pressures are not drawn.",
    ]
    assert made(run) == ["timeline.png", "timeline.svg"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.csv"], "none.csv: Cannot be read: No such file or directory."),
        (
            ["."],
            ".: This folder contains no recording. Name a folder that `eehal run --record`, `eehal demo` or",
        ),
        (["bad.csv"], "bad.csv:1: The header is 'hello'"),
        (["empty.csv"], "empty.csv: This recording holds no row, so there is nothing to draw."),
        (["never", "-o", "a.pdf"], "a.pdf: 'a.pdf' is neither .png nor .svg."),
        (
            ["never", "-o", "a.png", "--style", "both"],
            "a.png: Two figures do not fit into one file. Name a folder.",
        ),
        (["never", "-o", "bad.csv/x"], "The folder cannot be made: Not a directory."),
        (["never", "-o", "none/a.png"], "The figure cannot be written: No such file or directory."),
        (["never", "--style", "round"], "'round' is not one of 'timeline', 'paper', 'both'."),
        ([], "Missing argument 'STATES.csv'."),
    ],
)
def test_errors_are_sentences_with_exit_code_2(plot, run, monkeypatch, arguments, message):
    monkeypatch.chdir(run.parent)
    (run.parent / "bad.csv").write_text("hello\n")
    (run.parent / "empty.csv").write_text(",".join(FAILS_ONCE.columns) + "\n")
    code, out, err = plot(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert "Traceback" not in err
    assert made(run) == made(run.parent) == []


def test_the_help_needs_no_matplotlib(run):
    code = (
        "import sys; sys.argv = ['eehal', 'plot', '--help']; from end_effector_hal.cli import main\n"
        "try: main()\nfinally: assert 'matplotlib' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "timeline|paper|both" in done.stdout


def test_a_folder_with_traces_only_says_what_takes_them(tmp_path, plot):
    (tmp_path / "grip-0001.mcap").touch()
    code, _, err = plot(tmp_path)
    assert code
    assert "only traces" in err
    assert "`eehal page`, `eehal report` and `eehal replay`" in err


def test_the_list_of_scenarios_is_json_where_that_is_asked() -> None:
    words = CliRunner().invoke(command, ["--list"])
    assert [line.split()[0] for line in words.output.splitlines()] == [fault.usage for fault in FAULTS]
    told = json.loads(CliRunner().invoke(command, ["--list", "--json"]).output)
    assert told["schema_version"] == 1
    assert [each["usage"] for each in told["scenarios"]] == [fault.usage for fault in FAULTS]
