"""The trace of the program in real time: its lines, its arbiter, and the same decisions in replay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ArbiterError
from end_effector_hal.recording import RecordingLimits
from end_effector_hal.runtime import Program
from end_effector_hal.runtime.boundary import open_recorder
from end_effector_hal.verification.replay import load_trace, review, traces_of
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.support.lone_program import BOTTOM, CYLINDER, LINES, OFF, ON, TOP, Tool
from tests.unit.verification.replay.conftest import edited, numbers

pytestmark = pytest.mark.wall


def test_a_program_leaves_a_trace_of_what_it_heard_and_did(tmp_path: Path) -> None:
    tool, description = Tool(), load(profile_path())
    tool.program = Program(description, tool.arbiter, tool.told.append, open_recorder(tmp_path, description))
    tool.program.start()
    tool.grip_to(2)
    tool.arbiter.active = dict.fromkeys(LINES, OFF)  # the line arbiter took it for dead
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.program.arbiter_lost(ArbiterError("the lease ended."))
    tool.until(lambda status: status.ee == State.STAND_BY)
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    tool.arbiter.error = ArbiterError("the line arbiter cannot be reached.")
    tool.program.arbiter_lost(ArbiterError("the line arbiter was lost."))
    tool.until(lambda status: bool(status.alarm_texts))
    tool.arbiter.error = None
    tool.until(lambda status: not status.alarm_texts)
    assert tool.program.command("drop").accepted
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.until(lambda status: status.ee == State.STAND_BY)
    tool.program.close()
    trace = load_trace(tmp_path / "hal.mcap")
    found = review(trace)
    assert found.ok, found.as_json()
    assert trace.file.complete
    assert len(numbers(trace, "start")) == 2
    assert {content["there"] for n in numbers(trace, "arbiter") if (content := trace.content(n))} == {
        False,
        True,
    }
    lines = [trace.content(number) for number in numbers(trace, "lines")]
    levels = [
        (line, on) for content in lines if not content["error"] for line, on in content["levels"].items()
    ]
    assert [change for change in levels if change[1]][:2] == [(BOTTOM, ON), (CYLINDER, ON)]
    assert levels[-3:] == [(TOP, OFF), (CYLINDER, OFF), (BOTTOM, OFF)]
    assert any(step["line"] == BOTTOM for content in lines for step in content["will"])
    statuses = [trace.content(number)["ee"] for number in numbers(trace, "status")]
    assert statuses[-1] == State.STAND_BY
    written = numbers(trace, "lines", lambda content: content["levels"])
    assert len(written) > 8
    for number in written:
        false = review(edited(trace, number, invert))
        assert any("no decision asks for it" in each.what for each in false.objections), number
        assert not false.ok


def invert(content: dict[str, Any]) -> None:
    """Other levels than were written."""
    content["levels"] = {line: not level for line, level in content["levels"].items()}


def test_a_program_begins_segments_while_it_works(tmp_path: Path) -> None:
    tool, description = Tool(), load(profile_path())
    limits = RecordingLimits(30_000, 100_000_000)
    recorder = open_recorder(tmp_path, description, limits=limits)
    tool.program = Program(description, tool.arbiter, tool.told.append, recorder)
    tool.program.start()
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    tool.until(lambda _: len(traces_of(tmp_path)) >= 4)
    assert tool.program.command("drop").accepted
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.until(lambda status: status.ee == State.STAND_BY)
    tool.program.close()
    before = None
    for path in traces_of(tmp_path):
        found = review(load_trace(path), before=before)
        assert found.ok, found.as_json()
        assert review(load_trace(path)).ok
        assert found.trace.file.complete
        before = found.end


def test_a_folder_that_cannot_be_written_is_an_alarm_and_the_tool_works(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    tool, description = Tool(), load(profile_path())
    recorder = open_recorder(tmp_path / "file", description)
    tool.program = Program(description, tool.arbiter, tool.told.append, recorder)
    tool.program.start()
    alarm = f"The trace is not recorded: {tmp_path}/file: This is not a folder. ({tmp_path}/file)."
    tool.until(lambda status: alarm in status.alarm_texts)
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    assert tool.program.command("drop").accepted
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.until(lambda status: status.ee == State.STAND_BY)
    tool.program.close()
