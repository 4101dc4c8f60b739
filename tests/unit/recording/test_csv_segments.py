"""CSV files in segments: each can be read alone, and all that remain in a row."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import (
    RecordingLimits,
    StatesWriter,
    _files,
    read_alarms,
    read_pressures,
    read_states,
)
from end_effector_hal.recording._alarms import AlarmsWriter
from end_effector_hal.recording._pressures import PressuresWriter
from end_effector_hal.vocabulary import received_alarms
from tests.support.full_disk import FullDisk

LIMITS = RecordingLimits(400, 1_000_000)


def alone(path: Path, folder: Path) -> Path:
    """A segment without those before it."""
    folder.mkdir()
    return Path(shutil.copy(path, folder / "alone.csv"))


def segments(folder: Path, name: str) -> list[Path]:
    closed = [path for _, path in _files.numbered_files(folder / name)]
    return [*closed, folder / name]


def test_states_in_segments(tmp_path: Path) -> None:
    with StatesWriter(tmp_path / "states.csv", ("a", "b"), LIMITS) as writer:
        for number in range(60):
            assert writer.write(number, 1, 2, [number % 3, 0])
            assert not writer.write(number + 0.5, 1, 2, [number % 3, 0])
    paths = segments(tmp_path, "states.csv")
    assert [path.name for path in paths[:2]] == ["states-1.csv", "states-2.csv"]
    assert len(paths) > 3
    assert all(path.stat().st_size <= 400 for path in paths)
    rows = read_states(tmp_path / "states.csv").rows
    assert [row.time_s for row in rows] == list(range(60))
    last = None
    for number, path in enumerate(paths):
        found = read_states(alone(path, tmp_path / str(number))).rows
        assert last is None or found[0] == last, "it begins with the states that hold"
        last = found[-1]
    paths[0].unlink()  # the oldest was removed
    remaining = read_states(tmp_path / "states.csv").rows
    assert remaining == rows[-len(remaining) :]
    assert len(remaining) < 60


def test_states_go_on_after_a_restart_in_the_last_segment(tmp_path: Path) -> None:
    for part in range(3):
        with StatesWriter(tmp_path / "states.csv", ("a",), LIMITS) as writer:
            for number in range(part * 20, part * 20 + 20):
                writer.write(number, 1, 2, [number % 3])
    assert [row.time_s for row in read_states(tmp_path / "states.csv").rows] == list(range(60))


def test_pressures_in_segments(tmp_path: Path) -> None:
    with PressuresWriter(tmp_path / "pressures.csv", ("a",), LIMITS) as writer:
        for number in range(100):
            writer.write(number, {"a": float(number)})
    paths = segments(tmp_path, "pressures.csv")
    assert len(paths) > 2
    log = read_pressures(tmp_path / "pressures.csv")
    assert log.times_s == tuple(range(100))
    second = read_pressures(alone(paths[1], tmp_path / "x"))
    first = read_pressures(alone(paths[0], tmp_path / "y"))
    assert second.samples[0] == first.samples[-1]


def test_alarms_in_segments_begin_with_those_that_stand(tmp_path: Path) -> None:
    writer = AlarmsWriter(tmp_path / "alarms.csv", LIMITS)
    for number in range(40):
        alarms = received_alarms(["Always.", f"Number {number}."])
        assert writer.write(number, alarms)
        assert not writer.write(number, alarms)
    writer.close()
    paths = segments(tmp_path, "alarms.csv")
    assert len(paths) > 3
    rows = read_alarms(tmp_path / "alarms.csv")
    assert [row.text for row in rows if row.event == "begun"] == [
        "Always.",
        *(f"Number {n}." for n in range(40)),
    ]
    assert [row.text for row in rows if row.event == "ended"] == [f"Number {n}." for n in range(39)]
    begun = [row.text for row in read_alarms(alone(paths[2], tmp_path / "x"))][:2]
    assert begun[0] == "Always."
    assert begun[1].startswith("Number ")


def test_segments_of_another_recording_are_refused(tmp_path: Path) -> None:
    (tmp_path / "states-1.csv").write_text("time_s,end_effector,command,x\n")
    (tmp_path / "states.csv").write_text("time_s,end_effector,command,y\n")
    with pytest.raises(UsageError, match="that of the segment before"):
        read_states(tmp_path / "states.csv")


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> FullDisk:
    made = FullDisk()
    monkeypatch.setattr(_files, "os", made)
    return made


def test_a_state_that_came_and_went_while_the_disk_was_full_is_no_lasting_state(
    tmp_path: Path, disk: FullDisk
) -> None:
    with StatesWriter(tmp_path / "states.csv", ("a",)) as writer:
        assert writer.write(0, 3, -1, [2])
        disk.full = True
        with pytest.raises(ReportedError, match="No space left on device"):
            writer.write(1, 2, -1, [2])
        disk.full = False
        assert writer.write(2, 3, -1, [2])  # as the row before: but not all the time
        assert not writer.write(3, 3, -1, [2])
    assert [row.time_s for row in read_states(tmp_path / "states.csv").rows] == [0, 2]


def test_samples_that_were_lost_are_a_gap_in_the_curve(tmp_path: Path, disk: FullDisk) -> None:
    with PressuresWriter(tmp_path / "pressures.csv", ("a",)) as writer:
        writer.write(0, {"a": 1.0})
        disk.full = True
        for time_s in (1, 2):
            with pytest.raises(ReportedError):
                writer.write(time_s, {"a": 10.0 * time_s})
        disk.full = False
        writer.write(3, {"a": 50.0})
    assert read_pressures(tmp_path / "pressures.csv").samples == ((0, (1.0,)), (1, (None,)), (3, (50.0,)))


@pytest.mark.parametrize("left_out_s", [0.1, 0.3])
def test_a_gap_and_a_sample_left_out_stand_in_their_order(
    tmp_path: Path, disk: FullDisk, left_out_s: float
) -> None:
    with PressuresWriter(tmp_path / "pressures.csv", ("a",)) as writer:
        writer.write(0, {"a": 1.0})
        for time_s in sorted((0.2, left_out_s)):
            disk.full = time_s == 0.2
            if disk.full:
                with pytest.raises(ReportedError):
                    writer.write(time_s, {"a": 10.0})
            else:
                writer.write(time_s, {"a": 1.0})
        disk.full = False
        writer.write(0.4, {"a": 50.0})
    assert read_pressures(tmp_path / "pressures.csv").times_s == (0, *sorted((0.2, left_out_s)), 0.4)


def test_an_alarm_that_could_not_be_written_comes_with_the_next(tmp_path: Path, disk: FullDisk) -> None:
    writer = AlarmsWriter(tmp_path / "alarms.csv")
    disk.full = True
    with pytest.raises(ReportedError):
        writer.write(1, received_alarms(["One."]))
    disk.full = False
    assert writer.write(2, received_alarms(["One.", "Two."]))
    writer.close()
    assert [(row.time_s, row.text) for row in read_alarms(tmp_path / "alarms.csv")] == [
        (2, "One."),
        (2, "Two."),
    ]


def test_a_full_disk_at_a_segments_end_changes_nothing(tmp_path: Path, disk: FullDisk) -> None:
    with StatesWriter(tmp_path / "states.csv", ("a",), LIMITS) as writer:
        number = 0
        while (tmp_path / "states.csv").stat().st_size < 385:
            number += 1
            writer.write(number, 1, 2, [number % 3])
        disk.full = True
        with pytest.raises(ReportedError):
            writer.write(number + 1, 1, 2, [(number + 1) % 3])
        assert sorted(path.name for path in tmp_path.iterdir()) == ["states.csv"]
        disk.full = False
        assert writer.write(number + 2, 1, 2, [(number + 2) % 3])
    assert (tmp_path / "states-1.csv").exists()
    times = [row.time_s for row in read_states(tmp_path / "states.csv").rows]
    assert times == [*range(1, number + 1), number + 2]


def test_a_file_that_goes_is_a_sentence(tmp_path: Path) -> None:
    """What is written to it would be lost without a word."""
    with StatesWriter(tmp_path / "states.csv", ("a",), LIMITS) as writer:
        writer.write(0, 1, 2, [0])
        (tmp_path / "states.csv").rename(tmp_path / "elsewhere")
        with pytest.raises(ReportedError, match="No such file or directory"):
            writer.write(1, 1, 2, [1])
        shutil.copy(tmp_path / "elsewhere", tmp_path / "states.csv")
        with pytest.raises(ReportedError, match="another file is in its place"):
            writer.write(2, 1, 2, [0])
