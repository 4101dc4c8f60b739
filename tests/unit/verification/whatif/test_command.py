"""``eehal replay --description``: both stories, in words, as JSON and as a figure."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.page.recorded import OtherFiles, RecordingFiles, judge_recording, read_recording
from end_effector_hal.verification.whatif import changed_description, what_if
from end_effector_lab.figures import what_if as draw
from tests.unit.figures.figure_facts import overlaps, texts
from tests.unit.verification.whatif.conftest import ReadOnce

Other = Callable[..., Description]
SHORT = ("timeout_s: 5.0", "timeout_s: 0.25")


def run(*args: object) -> Result:
    return CliRunner().invoke(eehal, ["replay", *map(str, args)])


def test_the_story_stands_beside_the_recorded_one(gripped_twice: Path, other: Other, tmp_path: Path) -> None:
    target = tmp_path / "both.png"
    result = run(gripped_twice, "--description", other(SHORT).source, "-o", target)
    assert result.exit_code == 1
    assert "actuators.bottom_vacuum.timeout_s: 5.0 → 0.25" in result.output
    lines = result.output.splitlines()
    words = "+ Bottom vacuum was not confirmed within 0.25 s: attempt 1 of 3."
    lost, _ = [number for number, line in enumerate(lines) if words in line]
    # the mark stands right below what has led to it, and above what the recorded tool did then
    assert "from here on a guess: Bottom vacuum is inactive here" in lines[lost + 2]
    assert "- Bottom vacuum: ON" in lines[lost + 3]
    assert "A guess from 1.250 s to 10.200 s, 11.250 s to 14.200 s" in result.output
    assert target.read_bytes().startswith(b"\x89PNG")


def test_as_json(gripped_twice: Path, other: Other) -> None:
    result = run(gripped_twice, "--description", other(SHORT).source, "--json")
    (told,) = json.loads(result.output)["what_if"]
    assert not told["same"]
    assert [span["since_s"] for span in told["apart"]] == [1.25, 11.25]
    assert told["grips"][0]["other"]["attempts"][0]["outcome"] == "timed out"
    assert told["other"]["verdict"] == "2 grips: 2 GRIPPED"
    assert "what_if" not in json.loads(run(gripped_twice, "--json").output)


@pytest.mark.thinned
def test_of_many_runs_each_is_told(gripped_twice: Path, other: Other, tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / "runs" / name).mkdir(parents=True)
        shutil.copy(gripped_twice / "grip.mcap", tmp_path / "runs" / name)
    description = other(SHORT).source
    result = run(tmp_path / "runs", "--description", description)
    assert result.output.count("what if, with other.yaml") == 2
    with pytest.raises(UsageError, match="One figure shows one run"):
        raise run(tmp_path / "runs", "--description", description, "-o", "x.png").exception or AssertionError


def test_a_figure_needs_another_description(gripped_twice: Path) -> None:
    error = run(gripped_twice, "-o", "x.png").exception
    assert isinstance(error, UsageError)
    assert "nothing to draw beside" in str(error)


@pytest.mark.thinned
def test_the_figure_marks_where_the_runs_differ_and_where_it_is_a_guess(
    gripped_twice: Path, other: Other
) -> None:
    files = RecordingFiles(gripped_twice)
    figure = draw(what_if(files.entries(), files.description, other(SHORT)))
    marks = [line for axes in figure.axes for line in axes.lines if line.get_label() == "apart"]
    assert [line.get_xdata()[0] for line in marks] == [1.25, 11.25]
    spans = [patch for axes in figure.axes for patch in axes.patches]
    guesses = [
        (each.get_x(), each.get_x() + each.get_width()) for each in spans if each.get_label() == "guess"
    ]
    assert guesses == [pytest.approx((1.25, 10.2)), pytest.approx((11.25, 14.2))]
    differs = [each.get_x() for each in spans if each.get_label() == "differs"]
    assert min(differs) == 1.25
    assert {"Recorded", "With other.yaml", "Bottom vacuum time-out 1/3"} <= set(texts(figure))
    steps = [line for axes in figure.axes for line in axes.lines if str(line.get_label()).endswith(": level")]
    assert sorted({str(each.get_label()) for each in steps}) == [
        "switch cylinder_extended: level", "switch cylinder_retracted: level"
    ]  # fmt: skip
    assert len(steps) == 4, "both tools read the same switches"
    assert not overlaps(figure)
    assert len({axes.get_xlim() for axes in figure.axes}) == 1  # one axis of time


def test_the_same_story_has_no_mark(files: ReadOnce) -> None:
    figure = draw(what_if(files.entries(), files.description, files.description))
    labels = {str(each.get_label()) for axes in figure.axes for each in (*axes.lines, *axes.patches)}
    assert not labels & {"apart", "guess", "differs"}


@pytest.mark.thinned
def test_the_page_shows_it_beside_the_recording(gripped_twice: Path) -> None:
    files = RecordingFiles(gripped_twice)
    other = OtherFiles(
        files, changed_description("actuators.bottom_vacuum.timeout_s: 0.25", files.description)
    )
    document, recorded = read_recording(other).document, read_recording(files).document
    told = document["recording"]
    assert (told["name"], told["what_if"], recorded["recording"]["what_if"]) == ("what if", True, False)
    assert told["guesses"] == [[1.25, 10.2], [11.25, 14.2]]
    assert recorded["recording"]["guesses"] == []
    assert told["notes"][0] == "Other values than recorded: actuators.bottom_vacuum.timeout_s: 5.0 → 0.25."
    at = [entry["at"] for entry in document["log"] if entry["text"].startswith("From here on a guess")]
    assert at == [1_250_000, 11_250_000]
    goals = document["summary"]["goals"]
    assert "Bottom vacuum, attempt 1 of 3: timed out after 0.25 s" in goals[0]["why"]
    assert document["times"][-1] == recorded["times"][-1]
    assert judge_recording(other)["ok"] is None
