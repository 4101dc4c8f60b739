"""The files of a recording on a disk that is full for a while: what is missing is counted, said, and in run.json."""

from __future__ import annotations

import errno
import logging
import os
from pathlib import Path

import pytest

from end_effector_hal.control import EventKind, ToolEvent
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import (
    EventRow,
    Recording,
    RunInfo,
    _files,
    read_alarms,
    read_changer,
    read_pressures,
    read_run,
    read_states,
    read_switches,
)
from end_effector_hal.vocabulary import received_alarms
from tests.support.full_disk import FullDisk
from tests.support.parts import with_parts

DESCRIPTION = load(profile_path())
SECOND = 1_000_000
FULL = (
    "Rows of the recording cannot be written; writing is retried: "
    "A row could not be written: No space left on device."
)


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> FullDisk:
    made = FullDisk()
    monkeypatch.setattr(_files, "os", made)
    write = RunInfo.write

    def write_info(info: RunInfo, folder: str | Path) -> Path:
        if made.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(info, folder)

    monkeypatch.setattr(RunInfo, "write", write_info)
    return made


def test_what_is_missing_is_said_and_the_rest_is_there(tmp_path: Path, disk: FullDisk) -> None:
    with Recording(tmp_path, DESCRIPTION) as recording:
        start = recording._begun + SECOND
        recording.state(start, 3, -1, [2, 2, 2])
        recording.values(start, {"bottom": -80_000})
        disk.full = True
        for after in (1, 2, 3):
            with pytest.raises(ReportedError) as refused:
                recording.state(start + after * SECOND, 5 if after % 2 else 2, -1, [2, 2, 2])
            assert str(refused.value) == f"{tmp_path}: {FULL}"
        with pytest.raises(ReportedError):
            recording.alarms(start + 4 * SECOND, received_alarms(["Leak."]))
        with pytest.raises(ReportedError):
            recording.events(start + 4 * SECOND, [ToolEvent(start + 4 * SECOND, EventKind.NOT_GONE, 1)])
        with pytest.raises(ReportedError):  # what has nothing to write complains, too: it does not flicker
            recording.values(start + 4 * SECOND + 1, {"bottom": -80_000})
        disk.full = False
        recording.values(start + 5 * SECOND, {"bottom": -80_000})
        recording.state(start + 6 * SECOND, 6, -1, [0, 0, 0])
    log = read_states(tmp_path / "states.csv")
    assert [(row.time_s, row.end_effector) for row in log.rows] == [(0, 3), (5, 5), (6, 6)]
    assert log.events == (EventRow(4.0, EventKind.NOT_GONE, "cylinder"),)
    assert [(row.time_s, row.text) for row in read_alarms(tmp_path / "alarms.csv")] == [(5, "Leak.")]
    info = read_run(tmp_path)
    why = "A row could not be written: No space left on device."
    assert info.gaps == (f"From 1.000 s to 5.000 s 6 rows of this recording could not be written. {why}",)
    assert info.note == ""


def test_a_change_that_no_event_reports_has_a_row_of_its_own(tmp_path: Path) -> None:
    with Recording(tmp_path, DESCRIPTION) as recording:
        start = recording._begun + SECOND
        for second, state, events in (
            (0, 1, ()),
            (1, 3, [ToolEvent(start + SECOND, EventKind.STATE_CHANGED, old=1, new=3)]),
            (2, 0, ()),
        ):
            recording.state(start + second * SECOND, state, -1, [2, 2, 2])
            recording.events(start + second * SECOND, events)
    with Recording(tmp_path, DESCRIPTION) as recording:  # it was off for a while
        recording.state(start + 3 * SECOND, 6, -1, [0, 0, 0])
        recording.events(start + 3 * SECOND, ())
    events = read_states(tmp_path / "states.csv").events
    assert [(row.old, row.new) for row in events or ()] == [(1, 3), (3, 0), (0, 6)]


def test_a_recording_that_is_continued_keeps_what_it_said(tmp_path: Path, disk: FullDisk) -> None:
    for _ in range(2):
        with Recording(tmp_path, DESCRIPTION) as recording:
            recording.state(recording._begun + SECOND, 3, -1, [2, 2, 2])
            disk.full = True
            with pytest.raises(ReportedError):
                recording.state(recording._begun + 2 * SECOND, 2, -1, [2, 2, 2])
            disk.full = False
            recording.state(recording._begun + 3 * SECOND, 6, -1, [0, 0, 0])
    assert len(read_run(tmp_path).gaps) == 2


def test_one_that_ends_on_a_full_disk_ends(
    tmp_path: Path, disk: FullDisk, caplog: pytest.LogCaptureFixture
) -> None:
    with Recording(tmp_path, DESCRIPTION) as recording:
        start = recording._begun + SECOND
        recording.state(start, 3, -1, [2, 2, 2])
        recording.values(start, {"bottom": -80_000})
        recording.values(start + 100_000, {"bottom": -80_010})  # left out, and written at the end
        disk.full = True
        with caplog.at_level(logging.WARNING):
            recording.close()
    assert "No space left on device" in caplog.text
    assert len(read_states(tmp_path / "states.csv").rows) == 1


def test_a_disk_that_is_full_at_the_start_is_a_sentence(tmp_path: Path, disk: FullDisk) -> None:
    disk.full = True
    with pytest.raises(UsageError, match="Cannot be written: No space left on device"):
        Recording(tmp_path, DESCRIPTION)


@pytest.mark.parametrize("gaps", ["5", "{}", "[5]", '"x"', "null"])
def test_gaps_that_are_none_are_left_out(tmp_path: Path, gaps: str) -> None:
    (tmp_path / "run.json").write_text(f'{{"scenario": "x", "gaps": {gaps}}}')
    info = read_run(tmp_path)
    assert (info.scenario, info.gaps) == ("x", ())


def test_a_channel_of_another_link_keeps_its_value_until_it_is_stale(tmp_path: Path) -> None:
    """Of several links each brings frames of its own: what is not in a frame is not invalid."""
    tool = load(Path("examples/tools/two_links/end_effector.yaml"))
    with Recording(tmp_path, tool) as recording:
        start = recording._begun
        recording.state(start, 6, -1, [0, 0])
        recording.values(start, {"vacuum": -80_000})
        recording.values(start + 30_000, {"gripped": True})
        recording.values(start + SECOND, {"gripped": True})
        recording.values(start + SECOND + 30_000, {"vacuum": -70_000})
        recording.values(start + SECOND + 60_000, {"vacuum": None})
    log = read_pressures(tmp_path / "pressures.csv")
    curve = dict(zip(log.times_s, log.curve("vacuum"), strict=True))
    assert curve == {0.0: -80.0, 0.03: -80.0, 1.0: None, 1.03: -70.0, 1.06: None}


def test_switches_are_recorded_without_a_pressure_and_what_they_prove(tmp_path: Path) -> None:
    tool = load(Path("examples/tools/double_acting_jaw/end_effector.yaml"))
    with Recording(tmp_path, tool) as recording:
        start = recording._begun
        recording.state(start, 6, -1, [0])
        recording.values(start, {"jaw_open": True, "jaw_closed": False, "estop_ok": True})
        recording.values(start + 10_000, {"jaw_open": 1, "jaw_closed": 0, "estop_ok": 1})  # as ROS has them
        recording.values(start + SECOND, {"jaw_open": None, "jaw_closed": True, "estop_ok": True})
    log = read_switches(tmp_path / "switches.csv")
    assert (log.channels, log.rows) == (
        ("jaw_open", "jaw_closed", "estop_ok"), ((0.0, (True, False, True)), (1.0, (None, True, True)))
    )  # fmt: skip
    assert not (tmp_path / "pressures.csv").exists()
    info = read_run(tmp_path)
    assert info.switches["jaw_open"] == {"actuator": "jaw", "on": "gone", "off": ""}
    assert (info.e_stop, "estop_ok" in info.switches) == ("estop_ok", False)


def test_the_tool_changer_is_recorded_where_there_is_one(tmp_path: Path) -> None:
    for name, tool in (
        ("with", DESCRIPTION),
        ("without", load(Path("examples/tools/two_links/end_effector.yaml"))),
    ):
        with Recording(tmp_path / name, tool, ros=2) as recording:
            recording.tool_changer(recording._begun, 1)  # before the start: nothing to be placed at
            recording.state(recording._begun, 6, -1, [0] * len(tool.sequence))
            recording.tool_changer(recording._begun + SECOND, 3)
            recording.tool_changer(recording._begun + 2 * SECOND, 77)  # somebody else's number
    assert [int(row.state) for row in read_changer(tmp_path / "with" / "tool_changer.csv")] == [3, 0]
    assert not (tmp_path / "without" / "tool_changer.csv").exists()
    assert (read_run(tmp_path / "with").ros, read_run(tmp_path / "with").ros_generation) == (True, 2)


def test_the_part_is_recorded_of_a_tool_that_names_parts(tmp_path: Path) -> None:
    for name, tool in (("with", with_parts(DESCRIPTION)), ("without", DESCRIPTION)):
        with Recording(tmp_path / name, tool) as recording:
            recording.state(recording._begun, 6, -1, [0, 0, 0])
            for after, part in enumerate(("", "lid", "lid")):
                recording.part(recording._begun + after * SECOND, part)
            with pytest.raises(UsageError, match=r"'a,b' is not the name of a part\."):
                recording.part(recording._begun + 3 * SECOND, "a,b")
    rows = ["time_s,part", "0.000000,", "1.000000,lid"]
    assert (tmp_path / "with" / "parts.csv").read_text().splitlines() == rows
    assert not (tmp_path / "without" / "parts.csv").exists()
