"""``eehal replay``: its words and its exit codes."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import profile_path
from end_effector_hal.verification.replay import ProgramTrace, load_trace, review
from tests.unit.verification.replay.conftest import RecordedTool, edited, numbers


def run(*args: object) -> Result:
    return CliRunner().invoke(eehal, ["replay", *map(str, args)])


@pytest.fixture
def folder(tool: Callable[..., RecordedTool]) -> Path:
    played = tool()
    played.run(1.0)
    played.command("grip")
    played.run(4.0)
    played.close()
    return played.folder


def test_a_folder_is_replayed_program_by_program(folder: Path) -> None:
    result = run(folder)
    assert result.exit_code == 0
    assert result.output.count("decides the same") == 2
    assert result.output.count("a run of the network") == 2
    assert "tool_change of verdin_gripper" in result.output


def test_the_findings_as_json(folder: Path) -> None:
    result = run(folder / "grip.mcap", "--json")
    (found,) = json.loads(result.output)
    assert (result.exit_code, found["ok"], found["difference"], found["objections"]) == (0, True, None, [])
    assert found["recorded_hash"] == found["replayed_hash"]
    assert found["requirements"] > 10


def test_another_tool_decides_otherwise(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "end_effector.yaml"
    text = profile_path().read_text()
    other.write_text(text.replace("confirmed_kpa: 55.0", "confirmed_kpa: 75.0"))
    result = run(folder / "grip.mcap", "--description", other)
    assert result.exit_code == 1
    assert "replay: DIFFERS at " in result.output
    assert "Replayed with another description" in result.output


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_text("nothing")
    for place, what in ((tmp_path / "x.mcap", "no MCAP file"), (tmp_path / "none", "no trace here")):
        result = run(place)
        assert result.exit_code != 0
        assert getattr(result.exception, "exit_code", None) == 2
        assert what in str(result.exception)


def test_a_trace_that_is_cut_off_is_replayed_up_to_there(folder: Path, tmp_path: Path) -> None:
    """Wherever: nothing that was lost counts as a difference."""
    data = (folder / "grip.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    for length in range(len(data) - 10_000, len(data) - 90_000, -15_991):
        path.write_bytes(data[:length])
        found = review(load_trace(path))
        assert found.ok, (length, found.as_json())
        assert "The trace is not whole" in found.notes[0]


def test_a_changed_byte_is_told(folder: Path, tmp_path: Path) -> None:
    data = (folder / "grip.mcap").read_bytes()
    path = tmp_path / "changed.mcap"
    place = data.rindex(b'"device_ms":') + len(b'"device_ms":')
    path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])
    result = run(path)
    assert result.exit_code == 1
    assert "replay: decides the same" in result.output
    assert "note: The trace is damaged: bytes in it were changed since it was written." in result.output


def test_one_that_is_cut_within_its_header_says_so(folder: Path, tmp_path: Path) -> None:
    data = (folder / "grip.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    for length in (0, 5, 8, 100, 5_000, data.index(b'{"at":0,"program"') + 200):
        path.write_bytes(data[:length])
        result = run(path)
        assert getattr(result.exception, "exit_code", None) == 2
        assert f"The trace ends after {length} bytes, before its header" in str(result.exception)


def test_a_trace_without_a_header_does_not_keep_the_others_from_being_judged(folder: Path) -> None:
    (folder / "a_cut.mcap").write_bytes((folder / "grip.mcap").read_bytes()[:100])
    result = run(folder)
    assert result.exit_code == 2
    assert f"{folder}/a_cut.mcap: The trace ends after 100 bytes, before its header" in result.stderr
    assert result.stdout.count("decides the same") == 2
    found = json.loads(run(folder, "--json").stdout)
    assert [(Path(each["trace"]).name, each["ok"]) for each in found] == [
        ("grip.mcap", True),
        ("tool_change.mcap", True),
        ("a_cut.mcap", False),
    ]
    assert "before its header" in found[2]["faults"][0]["message"]


def test_one_that_differs_tells_more_than_one_that_cannot_be_read(folder: Path, tmp_path: Path) -> None:
    (folder / "a_cut.mcap").write_bytes(b"")
    other = tmp_path / "end_effector.yaml"
    other.write_text(profile_path().read_text().replace("confirmed_kpa: 55.0", "confirmed_kpa: 75.0"))
    assert run(folder, "--description", other).exit_code == 1


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
