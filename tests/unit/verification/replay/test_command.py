"""``eehal replay``: its words and its exit codes, and where a missed reaction bound is shown."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import load, profile_path
from end_effector_hal.recording import Recording, StatesWriter, read_run, read_states, run_info
from end_effector_hal.verification.replay import ProgramTrace, load_trace, review
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.figures import timeline
from end_effector_lab.figures._recorded_run import missed_moments
from tests.support.recorded_tool import RecordedTool
from tests.unit.verification.replay.conftest import edited, numbers


def run(*args: object) -> Result:
    return CliRunner().invoke(eehal, ["replay", *map(str, args)])


@pytest.fixture
def folder(tool: Callable[..., RecordedTool]) -> Path:
    played = tool()
    played.play(1.0, "grip", 4.0)
    played.close()
    return played.folder


def test_a_folder_is_replayed(folder: Path) -> None:
    result = run(folder)
    assert result.exit_code == 0
    assert result.output.count("decisions, all identical") == 1
    assert result.output.count("all allowed by the automata") == 1
    assert f"{folder}/hal.mcap: verdin_gripper (" in result.output


def test_the_findings_as_json(folder: Path) -> None:
    result = run(folder / "hal.mcap", "--json")
    (found,) = json.loads(result.output)["traces"]
    assert (result.exit_code, found["ok"], found["difference"], found["objections"]) == (0, True, None, [])
    assert found["recorded_hash"] == found["replayed_hash"]
    assert found["requirements"] > 10


def test_another_tool_decides_otherwise(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "end_effector.yaml"
    text = profile_path().read_text()
    other.write_text(text.replace("confirmed_kpa: 55.0", "confirmed_kpa: 75.0"))
    result = run(folder / "hal.mcap", "--description", other)
    assert result.exit_code == 1
    assert "replay: DIFFERS at " in result.output
    assert "Replayed with another description" in result.output


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_text("nothing")
    for place, what in ((tmp_path / "x.mcap", "not an MCAP file"), (tmp_path / "none", "no trace here")):
        result = run(place)
        assert result.exit_code != 0
        assert getattr(result.exception, "exit_code", None) == 2
        assert what in str(result.exception)


def test_a_trace_that_is_cut_off_is_replayed_up_to_there(folder: Path, tmp_path: Path) -> None:
    """Wherever: nothing that was lost counts as a difference."""
    data = (folder / "hal.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    for length in range(len(data) - 10_000, len(data) - 90_000, -15_991):
        path.write_bytes(data[:length])
        found = review(load_trace(path))
        assert found.ok, (length, found.as_json())
        assert "The trace is not whole" in found.notes[0]


def test_a_changed_byte_is_told(folder: Path, tmp_path: Path) -> None:
    data = (folder / "hal.mcap").read_bytes()
    path = tmp_path / "changed.mcap"
    place = data.rindex(b'"device_ms":') + len(b'"device_ms":')
    path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])
    result = run(path)
    assert result.exit_code == 1
    assert "decisions, all identical" in result.output
    assert "note: The trace is damaged: bytes in it were changed since it was written." in result.output


@pytest.mark.parametrize("within", [b'"attempts"', b"<committed/>"])
@pytest.mark.parametrize("closed", [True, False])
def test_a_changed_byte_of_the_description_does_not_blame_the_tool(
    folder: Path, tmp_path: Path, within: bytes, closed: bool
) -> None:
    data = bytearray((folder / "hal.mcap").read_bytes())
    data[data.index(within) + 2] ^= 1
    path = tmp_path / "changed.mcap"
    path.write_bytes(data if closed else data[:-3000])
    told = str(run(path).exception)
    why = (
        "The trace is damaged (bytes in it were changed"
        if closed
        else "Bytes of the description in this trace were changed"
    )
    assert told.startswith(f"{path}: {why}")
    assert "eehal-replay" not in told


def test_one_that_is_cut_within_its_header_says_so(folder: Path, tmp_path: Path) -> None:
    data = (folder / "hal.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    for length in (0, 5, 8, 100, 5_000, data.index(b'{"at":0,"description"') + 200):
        path.write_bytes(data[:length])
        result = run(path)
        assert getattr(result.exception, "exit_code", None) == 2
        assert f"The trace ends after {length} bytes, before its header" in str(result.exception)


def test_a_trace_without_a_header_does_not_keep_the_others_from_being_judged(folder: Path) -> None:
    (folder / "a_cut.mcap").write_bytes((folder / "hal.mcap").read_bytes()[:100])
    result = run(folder)
    assert result.exit_code == 2
    assert f"{folder}/a_cut.mcap: The trace ends after 100 bytes, before its header" in result.stderr
    assert result.stdout.count("decisions, all identical") == 1
    found = json.loads(run(folder, "--json").stdout)["traces"]
    assert [(Path(each["trace"]).name, each["ok"]) for each in found] == [
        ("hal.mcap", True),
        ("a_cut.mcap", False),
    ]
    assert "before its header" in found[1]["faults"][0]["message"]


def test_one_that_differs_tells_more_than_one_that_cannot_be_read(folder: Path, tmp_path: Path) -> None:
    (folder / "a_cut.mcap").write_bytes(b"")
    other = tmp_path / "end_effector.yaml"
    other.write_text(profile_path().read_text().replace("confirmed_kpa: 55.0", "confirmed_kpa: 75.0"))
    assert run(folder, "--description", other).exit_code == 1


@pytest.mark.thinned
def test_a_trace_may_end_in_the_middle_of_a_decision(gripped: ProgramTrace) -> None:
    (command,) = numbers(gripped, "command", lambda content: content["name"] == "drop")
    for end in range(command, command + 5):
        file = replace(gripped.file, records=gripped.file.records[:end], complete=False)
        assert review(replace(gripped, file=file)).ok
        whole = review(replace(gripped, file=replace(file, complete=True)))
        assert whole.ok is (end == command)


def test_a_description_that_has_changed_since_is_named(gripped: ProgramTrace, tmp_path: Path) -> None:
    source = tmp_path / "end_effector.yaml"
    source.write_text(profile_path().read_text().replace("confirmed_kpa: 55.0", "confirmed_kpa: 56.0"))
    header = numbers(gripped, "header")[0]
    moved = edited(gripped, header, lambda content: content.update(source=str(source)))
    found = review(replace(moved, header=replace(moved.header, source=str(source))))
    assert found.ok
    assert f"{source} or its automata have changed since ({moved.header.hash}, now " in found.notes[0]


def test_a_folder_of_runs_is_walked_into_and_ends_with_a_table(folder: Path, tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    for name in ("monday/1", "monday/2", "tuesday"):
        shutil.copytree(folder, runs / name)
    other = runs / "monday" / "2" / "hal.mcap"
    data = other.read_bytes()
    other.write_bytes(data.replace(b'"reason":""', b'"reason":"x"', 1)[: len(data)])
    (runs / "tuesday" / "hal.mcap").write_bytes(b"")
    (runs / "notes.txt").touch()
    (runs / "again").symlink_to(runs / "monday")
    result = run(runs)
    *_, head, first, second, third, sum_ = (line.rstrip() for line in result.stdout.splitlines())
    assert head.split() == ["run", "traces", "seconds", "inputs", "decisions", "replay"]
    assert (first.split()[:2], first[-8:]) == (["monday/1", "1"], "the same")
    assert second.split()[0] == "monday/2"
    assert not second.endswith("the same")
    assert (third.split()[0], third.endswith("1 unreadable")) == ("tuesday", True)
    assert sum_ == "3 runs: 1 identical, 2 not identical or unreadable"
    assert result.exit_code in (1, 2)
    assert "monday/1/hal.mcap" not in result.stdout  # of what is as recorded the table says enough
    told = json.loads(run(runs, "--json").stdout)
    assert (told["schema_version"], told["ok"], len(told["traces"])) == (1, False, 3)


def test_a_folder_that_cannot_be_read_is_told_and_the_others_are_judged(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the kernel refuses it; root, who runs many tests, may read every folder."""
    runs, scan, listing = tmp_path / "runs", os.scandir, os.listdir
    for name in ("closed", "open"):
        shutil.copytree(folder, runs / name)

    def refusing(real: Callable[[str], object]) -> Callable[[str], object]:
        def read(path: str) -> object:
            if Path(path) == runs / "closed":
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
            return real(path)

        return read

    monkeypatch.setattr(os, "scandir", refusing(scan))
    monkeypatch.setattr(os, "listdir", refusing(listing))
    result = run(runs)
    assert result.exit_code == 2
    assert "closed: Cannot be read: Permission denied." in result.stderr
    assert result.stdout.splitlines()[-1] == "2 runs: 1 identical, 1 not identical or unreadable"


def test_a_folder_without_a_run_says_so(tmp_path: Path) -> None:
    (tmp_path / "runs" / "empty").mkdir(parents=True)
    result = run(tmp_path / "runs")
    assert "There is no trace here." in str(result.exception)


def test_a_number_that_differs_has_its_word_beside_it(gripped: ProgramTrace) -> None:
    (last,) = numbers(gripped, "status", lambda content: content["ee"] == EndEffectorState.GRIPPED)[:1]
    changed = edited(gripped, last, lambda content: content.update(ee=EndEffectorState.RELEASING))
    found = review(changed)
    assert str(found.replay.difference) == "status.ee: recorded 4 (RELEASING), replayed 3 (GRIPPED)"
    told = found.as_json()["difference"]
    assert (told["recorded"], told["recorded_name"], told["replayed_name"]) == (4, "RELEASING", "GRIPPED")


# A missed reaction bound is shown where a run is looked at: in the figure, and in what replay says.


@pytest.fixture
def missed(tool: Callable[..., RecordedTool]) -> Path:
    """The first time-out is taken 63 ms late, at 6.063 s; the recording begins at 0.5 s."""
    played = tool("never-confirms:bottom_vacuum")
    played.play(1.0, "grip", 4.9)
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


def test_the_figure_marks_it_at_its_time(missed: Path) -> None:
    (moment,), notes = missed_moments(missed)
    assert (moment.kind, moment.time_s, moment.text) == ("missed", 5.563, "bound missed, 63 ms late")
    assert notes == ()
    figure = timeline(read_states(missed / "states.csv"), info=read_run(missed), moments=[moment])
    words = [text.get_text() for axes in figure.axes for text in axes.texts if text.get_label() == "event"]
    assert "bound missed, 63 ms late" in words


def test_the_commands_tell_it(missed: Path) -> None:
    plot = CliRunner().invoke(eehal, ["plot", str(missed), "-o", str(missed / "figure.svg")])
    assert (plot.exit_code, "At 5.563 s: bound missed, 63 ms late" in plot.output) == (0, True)
    story = json.loads(CliRunner().invoke(eehal, ["plot", str(missed), "--json"]).output)
    assert story["missed"] == [{"time_s": 5.563, "text": "bound missed, 63 ms late"}]
    replayed = CliRunner().invoke(eehal, ["replay", str(missed)])
    assert replayed.exit_code == 0
    assert "at 6.063000 s, missed: Gripper Step → Reset" in replayed.output


def test_a_trace_that_cannot_be_read_is_a_note(missed: Path) -> None:
    (missed / "other.mcap").write_text("no trace")
    moments, (note,) = missed_moments(missed)
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
