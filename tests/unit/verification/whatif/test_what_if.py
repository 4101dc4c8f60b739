"""The whole other story of a recorded run, and from where on it is a guess."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.description import Description
from end_effector_hal.page.recorded import RecordingFiles
from end_effector_hal.recording import GripDecision
from end_effector_hal.verification.replay import Entry
from end_effector_hal.verification.whatif import GUESS, OtherRun, WhatIf, what_if
from tests.support.recorded_tool import RecordedTool
from tests.unit.verification.whatif.conftest import ReadOnce

Other = Callable[..., Description]
SHORT = ("timeout_s: 5.0", "timeout_s: 0.25")
HIGH = ("confirmed_kpa: 55.0", "confirmed_kpa: 75.0")


def played(files: RecordingFiles | ReadOnce, other: Description) -> WhatIf:
    return what_if(files.entries(), files.description, other)


def only(told: WhatIf, *, other: bool) -> list[tuple[float, str]]:
    """What happened in one of the two only."""
    return [
        (line.time_s, line.text)
        for line in told.lines
        if (line.recorded_s if other else line.other_s) is None
    ]


def test_the_same_description_tells_the_same_story(files: ReadOnce) -> None:
    told = played(files, files.description)
    assert told.same
    assert not told.spans
    assert not told.notes
    assert told.recorded.story == told.other.story
    assert len(told.lines) > 30


def test_a_program_that_stood_still_is_as_late_in_the_other_story(tmp_path: Path) -> None:
    """Far beyond its bound: nobody decided anything meanwhile, whatever the description."""
    tool = RecordedTool(tmp_path / "run")
    tool.run(1.0)
    tool.command("grip")
    tool.run(0.2)
    tool.at += 400_000  # the readings have become stale in between
    tool.run(3.0)
    tool.close()
    files = RecordingFiles(tool.folder)
    told = played(files, files.description)
    assert told.same
    assert any("No valid reading" in line.text for line in told.lines)


@pytest.mark.thinned
def test_a_time_out_that_nothing_reaches_changes_nothing_but_the_deadline(
    files: RecordingFiles, other: Other
) -> None:
    told = played(files, other(("timeout_s: 5.0", "timeout_s: 2.0")))
    assert told.same
    assert not told.spans


def test_a_shorter_time_out_is_taken_on_time_and_the_rest_is_a_guess(
    files: RecordingFiles, other: Other
) -> None:
    told = played(files, other(SHORT))
    first, second = told.grips
    assert first.recorded is not None
    assert first.other is not None
    assert [str(each) for each in first.other.of("bottom_vacuum")] == [
        "Bottom vacuum, attempt 1 of 3: timed out after 0.25 s",
        "Bottom vacuum, attempt 2 of 3: confirmed after 0.00 s",
    ]
    assert (first.guess_s, second.guess_s) == (1.25, 11.25)
    assert (1.25, "Bottom vacuum was not confirmed within 0.25 s: attempt 1 of 3.") in only(told, other=True)
    assert (1.4, "Bottom vacuum: ON") in only(told, other=False)
    # both at rest: the second grip begins on readings that are its own
    assert [(told.seconds(span.since), span.until and told.seconds(span.until)) for span in told.spans] == [
        (1.25, 10.2),
        (11.25, 14.2),
    ]
    assert told.spans[0].why == "Bottom vacuum is inactive here and was active in the recorded run."


def test_a_higher_threshold_confirms_later(files: ReadOnce, other: Other) -> None:
    told = played(files, other(HIGH))
    waits = [grip.of("bottom_vacuum")[0].length_s for grip in told.other.story.grips]
    assert waits == pytest.approx([1.02, 1.02], abs=0.03)
    # until then nothing differs, and what differs first is what the recorded tool did
    assert told.seconds(told.spans[0].since) == 1.4
    assert told.spans[0].why == "Cylinder is inactive here and was active in the recorded run."


@pytest.mark.thinned
def test_until_the_outputs_differ_the_other_story_is_what_really_happens(
    tmp_path: Path, other: Other
) -> None:
    """The same tool really driven with the other description: equal up to the instant that is told."""
    tools = [RecordedTool(tmp_path / "recorded"), RecordedTool(tmp_path / "real", description=other(HIGH))]
    for tool in tools:
        tool.run(1.0)
        tool.command("grip")
        tool.run(2.0)
        tool.close()
    recorded, real = (RecordingFiles(tool.folder) for tool in tools)
    told, truth = played(recorded, real.description), played(real, real.description)
    until = told.seconds(told.spans[0].since)
    happened, said = (
        [line for line in side.lines if line.time_s <= until] for side in (truth.recorded, told.other)
    )
    assert said == happened
    assert len(said) >= 4


@pytest.mark.thinned
def test_a_program_hears_what_the_other_one_would_say(tmp_path: Path, other: Other) -> None:
    """The recorded tool had dropped its part when it was unlocked; the other one is still gripping."""
    tool = RecordedTool(tmp_path / "run")
    tool.run(1.0)
    tool.command("grip")
    tool.run(3.0)
    tool.command("drop")
    tool.run(4.0)
    tool.command("arm")
    assert tool.command("unlock").accepted
    tool.run(1.0)
    tool.close()
    never = other(("confirmed_kpa: 55.0", "confirmed_kpa: 95.0\n    secure_kpa: 96.0"))
    told = played(RecordingFiles(tool.folder), never)
    (refused,) = [text for _, text in only(told, other=True) if text.startswith("refused: unlock")]
    assert "IL-01" in refused
    assert not told.other.changer[-1].state.name.startswith("UNLOCK")
    assert told.recorded.changer[-1].state.name.startswith("UNLOCK")


def test_what_cannot_be_read_ends_the_story_there(files: ReadOnce, other: Other) -> None:
    entries = [entry for entry in files.entries() if entry.at < 5_000_000]
    broken = [*entries, Entry(5_000_000, "grip", "unreadable", None)]
    run = OtherRun(files.description, files.description)
    list(run.play(broken))
    assert run.notes == ["At 5.000 s the grip program ends, for its trace cannot be read any further."]
    assert [(span.since, span.until) for span in run.spans] == [(5_000_000, None)]


def test_records_that_make_no_sense_are_told(files: ReadOnce) -> None:
    entries = list(files.entries())
    number = next(n for n, each in enumerate(entries) if each.kind == "command")
    bad = entries[number]._replace(record=type(entries[number].record)(entries[number].at, "no such command"))
    run = OtherRun(files.description, files.description)
    list(run.play([*entries[:number], bad, *entries[number + 1 :]]))
    assert run.apart_since is not None


def test_a_recording_that_begins_in_the_middle_goes_on_from_its_state(tmp_path: Path, other: Other) -> None:
    tool = RecordedTool(tmp_path / "run")
    tool.run(1.0)
    tool.command("grip")
    tool.run(1.0)
    state, at = tool.grip.snapshot(), tool.at
    tool.run(2.0)
    tool.close()
    assert state is not None
    rest = [
        entry for entry in RecordingFiles(tool.folder).entries() if entry.at > at and entry.program == "grip"
    ]
    run = OtherRun(other(HIGH), tool.description)
    out = list(run.play([Entry(at, "grip", "state", state), *rest]))
    assert "goes on from the recorded state" in run.notes[0]
    grips = [entry.record.ee.name for entry in out if entry.kind == "status"]
    assert grips[-1] == "GRIPPED"


def test_the_guess_is_told_at_its_instant(files: ReadOnce, other: Other) -> None:
    run = OtherRun(other(SHORT), files.description)
    told = [entry for entry in run.play(files.entries()) if entry.kind == GUESS]
    assert [entry.at for entry in told] == [span.since for span in run.spans] == [1_250_000, 11_250_000]
    assert told[0].record == (
        "From here on a guess: Bottom vacuum is inactive here and was active in the recorded run."
    )


def test_a_refusal_of_other_outputs_is_left_out(files: ReadOnce, other: Other) -> None:
    from end_effector_hal.runtime.boundary import INPUTS

    entries = list(files.entries())
    number = next(n for n, each in enumerate(entries) if each.at >= 1_600_000)
    refusal = Entry(entries[number].at, "grip", "refused", INPUTS["refused"](entries[number].at))
    told = what_if([*entries[:number], refusal, *entries[number:]], files.description, other(SHORT))
    assert told.other.story.grips[0].decision is GripDecision.GRIPPED
    assert "1 refusal of the line arbiter" in told.notes[0]
