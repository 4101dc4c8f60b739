"""A missed reaction bound is shown where a run is looked at: in the figure, and in what replay says."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import load, profile_path
from end_effector_hal.recording import Recording, StatesWriter, read_run, read_states, run_info
from end_effector_lab.figures import timeline
from end_effector_lab.figures._recorded_run import missed_moments
from tests.support.recorded_tool import RecordedTool


@pytest.fixture
def folder(tool: Callable[..., RecordedTool]) -> Path:
    """The first time-out is taken 63 ms late, at 6.063 s; the recording begins at 0.5 s."""
    played = tool("never-confirms:bottom_vacuum")
    played.run(1.0)
    played.command("grip")
    played.run(4.9)
    played.controller.advance(6_063_000)
    played.at = 6_063_000
    played.run(3.0)
    played.close()
    replace(run_info(played.description), start_us=500_000).write(played.folder)
    with StatesWriter(played.folder / "states.csv", played.description.sequence) as states:
        for status in played.statuses:
            if status.at >= 500_000:
                states.write((status.at - 500_000) / 1e6, status.ee, status.command, status.actuators)
    return played.folder


def test_the_figure_marks_it_at_its_time(folder: Path) -> None:
    (moment,), notes = missed_moments(folder)
    assert (moment.kind, moment.time_s, moment.text) == ("missed", 5.563, "bound missed, 63 ms late")
    assert notes == ()
    figure = timeline(read_states(folder / "states.csv"), info=read_run(folder), moments=[moment])
    words = [text.get_text() for axes in figure.axes for text in axes.texts if text.get_label() == "event"]
    assert "bound missed, 63 ms late" in words


def test_the_commands_tell_it(folder: Path) -> None:
    plot = CliRunner().invoke(eehal, ["plot", str(folder), "-o", str(folder / "figure.svg")])
    assert (plot.exit_code, "At 5.563 s: bound missed, 63 ms late" in plot.output) == (0, True)
    story = json.loads(CliRunner().invoke(eehal, ["plot", str(folder), "--json"]).output)
    assert story["missed"] == [{"time_s": 5.563, "text": "bound missed, 63 ms late"}]
    replayed = CliRunner().invoke(eehal, ["replay", str(folder)])
    assert replayed.exit_code == 0
    assert "at 6.063000 s, missed: Gripper Step → Reset" in replayed.output


def test_a_trace_that_cannot_be_read_is_a_note(folder: Path) -> None:
    (folder / "other.mcap").write_text("no trace")
    moments, (note,) = missed_moments(folder)
    assert len(moments) == 1
    assert "not an MCAP file. Its missed bounds are not drawn." in note


def test_a_recording_says_when_it_began(tmp_path: Path) -> None:
    description = load(profile_path())
    with Recording(tmp_path, description) as recording:
        assert read_run(tmp_path).start_us is None
        at = 1 << 62
        recording.state(at, 6, -1, [0, 0, 0])
        assert read_run(tmp_path).start_us == at
        assert recording.seconds(at + 1_500_000) == 1.5
