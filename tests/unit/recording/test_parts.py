"""A recording of a tool that names its parts: each grip is of one, and is judged by its values."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.page.recorded import RecordedTables, RecordingFiles, read_recording
from end_effector_hal.recording import (
    Recording,
    RunInfo,
    read_pressures,
    read_run,
    read_states,
    read_story,
    run_info,
)
from end_effector_lab.figures import timeline
from end_effector_lab.recorded import GripCollector, tune
from tests.support.named_parts import gripper_with_parts
from tests.support.recorded_tool import recorded
from tests.unit.figures.figure_facts import texts
from tests.unit.verification.replay.test_command import run as replayed


@pytest.fixture(scope="module")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Description:
    return gripper_with_parts(tmp_path_factory.mktemp("tool"))


@pytest.fixture(scope="module")
def trace(tool: Description, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A box on the second attempt, then a panel."""
    plan = (1.0, "grip box", 6.0, "drop", 3.0, "grip panel", 5.0, "drop", 4.0)
    folder = tmp_path_factory.mktemp("trace") / "run"
    return recorded(folder, "fails-once:bottom_vacuum", *plan, description=tool)


@pytest.fixture(scope="module")
def tables(tool: Description, trace: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run as a program writes its tables."""
    files, folder = RecordingFiles(trace), tmp_path_factory.mktemp("tables") / "run"
    with Recording(folder, tool, now=lambda: files.begin) as recording:
        for _, kind, record in files.entries():
            if kind == "status":
                recording.state(record.at, record.ee, record.command, record.actuators)
                recording.part(record.at, record.part)
                recording.events(record.at, record.events)
            elif kind == "frame":
                recording.values(record.stamp, record.values)
    return folder


def test_the_trace_is_replayed_with_its_parts(trace: Path) -> None:
    found = replayed(trace)
    assert found.exit_code == 0, found.output


def test_the_table_of_parts_is_read_with_the_states(tables: Path) -> None:
    log = read_states(tables / "states.csv")
    assert [name for _, name in log.part_rows] == ["", "box", "", "panel", ""]
    assert log.parts == ("box", "panel")
    (tables / "parts.csv").rename(tables / "kept.csv")
    assert read_states(tables / "states.csv").parts == ()
    (tables / "kept.csv").rename(tables / "parts.csv")


def test_a_part_that_is_no_name_is_refused_with_its_line(tables: Path, tmp_path: Path) -> None:
    shutil.copy(tables / "states.csv", tmp_path)
    (tmp_path / "parts.csv").write_text("time_s,part\n0.0,a box\n")
    with pytest.raises(UsageError, match=r"parts\.csv:2.*part is 'a box'"):
        read_states(tmp_path / "states.csv")


def test_the_story_names_the_parts_and_counts_their_attempts(tables: Path) -> None:
    info, log = read_run(tables), read_states(tables / "states.csv")
    assert info.attempts("bottom_vacuum", "box") == 2
    assert info.attempts("bottom_vacuum", "panel") == 3
    story = read_story(log, info)
    assert [(grip.part, len(grip.of("bottom_vacuum"))) for grip in story.grips] == [("box", 2), ("panel", 1)]
    assert {(grip.part, each.of) for grip in story.grips for each in grip.of("bottom_vacuum")} == {
        ("box", 2),
        ("panel", 3),
    }
    assert story.verdict == "2 grips: 1 GRIPPED box, 1 GRIPPED panel"
    assert [each.text for each in story.moments if each.kind == "command"] == [
        "GRIP box", "DROP", "GRIP panel", "DROP",
    ]  # fmt: skip


def test_limits_that_differ_among_the_parts_are_not_drawn(tool: Description, tables: Path) -> None:
    info = run_info(tool)
    cup = {part: info.gripping([part]).limits["bottom_vacuum"] for part in ("box", "panel")}
    assert (cup["box"]["confirmed_kpa"], cup["panel"]["confirmed_kpa"]) == (40.0, 55.0)
    both = info.gripping(["box", "panel"]).limits["bottom_vacuum"]
    assert "confirmed_kpa" not in both
    assert both["gone_kpa"] == 10.0
    assert info.gripping([]) == info
    assert RunInfo().gripping(["box"]) == RunInfo()
    figure = timeline(read_states(tables / "states.csv"), read_pressures(tables / "pressures.csv"), info)
    assert {"2 grips: 1 GRIPPED box, 1 GRIPPED panel", "GRIP box", "GRIP panel"} <= set(texts(figure))


@pytest.mark.parametrize("traced", [True, False])
def test_the_page_of_a_recording_names_the_parts(
    tool: Description, trace: Path, tables: Path, traced: bool
) -> None:
    files = RecordingFiles(trace) if traced else RecordedTables(tables, tool)
    document = read_recording(files).document
    goals = [goal["what"] for goal in document["summary"]["goals"]]
    assert goals == ["Grip box", "Drop", "Grip panel", "Drop"]
    words = document["tracks"]["state.word"][1]
    assert {"GRIPPED: box", "GRIPPED: panel", "STAND_BY"} <= set(words)


def test_each_part_is_tuned_by_its_own_grips(tool: Description, trace: Path) -> None:
    collector = GripCollector(tool)
    assert collector.collect(RecordingFiles(trace).entries(), 0) == 2
    assert [grip.part for grip in collector.grips] == ["box", "panel"]
    found = {(each.parameter.part, each.parameter.key): each for each in tune(collector.grips, tool).tried}
    own = "actuators.bottom_vacuum.confirmed_kpa"
    box, panel = found["box", f"parts.box.{own}"], found["panel", f"parts.panel.{own}"]
    assert (box.parameter.today, panel.parameter.today) == (40.0, 55.0)
    assert (box.grips, panel.grips) == (1, 1)
    assert (box.today.late, panel.today.late) == (1, 0)
    assert ("panel", "parts.panel.actuators.cylinder.timeout_s") in found
    assert ("box", "parts.box.actuators.cylinder.timeout_s") not in found, "nothing of it was gripped"
    assert ("box", "actuators.bottom_vacuum.release_s") in found, "it is the same for all parts"
    printed = CliRunner().invoke(eehal, ["tune", str(trace)], catch_exceptions=False).output
    assert own.replace("actuators", "parts.box.actuators") in printed
    assert "bottom_vacuum.release_s (box)" in printed


def test_grips_of_a_part_that_the_tool_does_not_have_are_set_aside(trace: Path) -> None:
    collector = GripCollector(load(profile_path()))
    collector.collect(RecordingFiles(trace).entries(), 0)
    found = tune(collector.grips, load(profile_path()))
    assert found.set_aside == {"bottom_vacuum": 2, "cylinder": 1, "top_vacuum": 1}
    assert not found.tried
