"""A trace in segments: each is replayed alone and in a row; what was changed in a later one is found, too."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import Gap, RecordingLimits
from end_effector_hal.verification.replay import (
    ProgramTrace,
    Review,
    SegmentEnd,
    load_trace,
    review,
    traces_of,
)
from end_effector_hal.vocabulary import Cause, EndEffectorState
from tests.support.nightly import first_of
from tests.support.recorded_tool import RecordedTool
from tests.unit.verification.replay.conftest import Edit, edited, numbers

LIMITS = RecordingLimits(segment_bytes=60_000, total_bytes=100_000_000)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A grip in which the cylinder fails once, a silence while it is held, a Drop, a cancelled grip."""
    tool = RecordedTool(tmp_path_factory.mktemp("segments"), "fails-once:cylinder", limits=LIMITS)
    tool.play(1.0, "grip", 9.0)
    tool.link = False
    tool.run(1.5)
    tool.link = True
    tool.play(2.0, "drop", 3.0, "grip", 0.7, "cancel", 3.0)
    tool.close()
    return tool.folder


@pytest.fixture(scope="module")
def segments(folder: Path) -> tuple[ProgramTrace, ...]:
    """In order."""
    return tuple(map(load_trace, traces_of(folder)))


def in_a_row(traces: Iterator[ProgramTrace] | tuple[ProgramTrace, ...]) -> list[Review]:
    found: list[Review] = []
    before: SegmentEnd | None = None
    for trace in traces:
        found.append(review(trace, before=before))
        before = found[-1].end
    return found


def test_a_long_trace_is_cut_into_segments_that_name_each_other(segments: tuple[ProgramTrace, ...]) -> None:
    assert len(segments) > 5
    headers = [trace.header for trace in segments]
    assert [header.segment for header in headers] == list(range(1, len(segments) + 1))
    assert len({header.run for header in headers}) == 1
    assert [header.follows for header in headers] == [False] + [True] * (len(segments) - 1)
    assert all(header.gap is None for header in headers)
    for trace in segments:
        assert trace.file.complete
        assert not trace.file.damaged
        assert [record.kind for record in trace.file.records[:2]] == [
            "header",
            "start" if trace.header.segment == 1 else "state",
        ]
    states = {trace.content(1)["status"]["ee"] for trace in segments[1:]}
    assert len(states) >= 3, "they begin in several states of the gripping"


def test_each_segment_is_replayed_alone(segments: tuple[ProgramTrace, ...]) -> None:
    for trace in segments:
        found = review(trace)
        assert found.ok, found.as_json()
        assert found.objections == ()
        # the last one has what was left, which may be nothing
        assert found.replay.inputs > 50 or trace is segments[-1]
        assert found.requirements > 10
        alone = f"This is segment {trace.header.segment}: it is judged from the state with which it begins."
        assert found.notes == ((alone,) if trace.header.segment > 1 else ())


@pytest.mark.parametrize("first", first_of([3, 0, 1]))
def test_all_that_remain_are_replayed_in_a_row(segments: tuple[ProgramTrace, ...], first: int) -> None:
    """The oldest were removed."""
    found = in_a_row(segments[first:])
    assert [each.ok for each in found] == [True] * len(found)
    assert all(each.objections == () for each in found)
    assert sum(each.steps for each in found) > 0
    assert all(each.notes == () for each in found[1:])
    assert all(each.end.state is not None and each.end.execution is not None for each in found)


def later(segments: tuple[ProgramTrace, ...], kind: str) -> int:
    """A segment but the first that has a record of this kind."""
    return next(n for n, trace in enumerate(segments) if n > 0 and numbers(trace, kind))


def faulty(found: list[Review]) -> list[int]:
    return [each.trace.header.segment for each in found if not each.ok]


@pytest.mark.parametrize(
    "change",
    first_of(
        [
            ("command", lambda content: content.update(name="lock")),
            ("step", lambda content: content.update(late_us=1)),
            ("status", lambda content: content.update(ee=5)),
            ("step", lambda content: content.update(missed=True)),
            ("event", lambda content: content.update(channel="gone[2]")),
            ("answer", lambda content: content.update(accepted=False)),
        ],
        3,
    ),
)
def test_what_was_changed_in_a_later_segment_is_found(
    segments: tuple[ProgramTrace, ...], change: tuple[str, Edit]
) -> None:
    kind, edit = change
    place = later(segments, kind)
    changed = edited(segments[place], numbers(segments[place], kind)[-1], edit)
    assert not review(changed).ok
    row = (*segments[:place], changed, *segments[place + 1 :])
    assert place + 1 in faulty(in_a_row(row))


@pytest.mark.parametrize("kind", first_of(["step", "state", "event", "status"], 2))
def test_what_was_left_out_in_a_later_segment_is_found(segments: tuple[ProgramTrace, ...], kind: str) -> None:
    place = later(segments, kind)
    changed = edited(segments[place], numbers(segments[place], kind)[0], None)
    assert not review(changed).ok


def set_at(*path: str | int, value: Any) -> Edit:
    def edit(content: dict[str, Any]) -> None:
        inner: Any = content
        for key in path[:-1]:
            inner = inner[key]
        assert inner[path[-1]] != value
        inner[path[-1]] = value

    return edit


@pytest.mark.parametrize(
    "edit",
    first_of(
        [
            set_at("status", "held", value=True),
            set_at("memory", "_senses", "_detectors", 0, "_above", "samples", value=77),
            set_at("execution", "variables", "cause_at", value=1),
            set_at("at", value=1),
            set_at("memory", "_senses", "readings", "last_frame", value=1),
            set_at("memory", "_hold", "_since", value=5),
            set_at("memory", "_statuses", "_missed", value=1),
            set_at("execution", "entered", value=1),
            set_at("execution", "zeros", value={}),
        ],
        4,
    ),
)
def test_a_state_that_is_not_where_the_segment_before_it_ends_is_found(
    segments: tuple[ProgramTrace, ...], edit: Edit
) -> None:
    changed = edited(segments[1], 1, edit)
    found = review(changed, before=review(segments[0]).end)
    assert not found.ok
    assert found.replay.difference.what.startswith("state")


def test_the_monitor_finds_a_changed_state_by_itself(segments: tuple[ProgramTrace, ...]) -> None:
    end = replace(review(segments[0]).end, state=None)  # as if the replay knew nothing
    clock = next(iter(segments[1].content(1)["execution"]["zeros"]))
    changed = edited(segments[1], 1, lambda content: content["execution"]["zeros"].update({clock: -1}))
    found = review(changed, before=end)
    assert [each.kind for each in found.objections][:1] == ["no run"]
    assert f"zeros {clock}" in found.objections[0].what


def test_a_segment_that_is_missing_in_between_is_found(segments: tuple[ProgramTrace, ...]) -> None:
    found = in_a_row((*segments[:2], *segments[3:]))
    assert faulty(found) == [4]
    assert "Between segment 2 and this one, 4, others are missing." in found[2].objections[0].what


def test_segments_that_changed_places_are_found(segments: tuple[ProgramTrace, ...]) -> None:
    assert faulty(in_a_row((segments[0], segments[2], segments[1])))


def test_a_segment_that_was_cut_off_afterwards_is_found(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "cut")
    path = tmp_path / "cut" / "hal-3.mcap"
    path.write_bytes(path.read_bytes()[:-20_000])
    found = in_a_row(map(load_trace, traces_of(tmp_path / "cut")))
    assert faulty(found) == [4]
    assert "Segment 3 was closed in good order, but its end is missing now" in found[3].objections[0].what
    assert any("not whole" in note for note in found[2].notes)


def test_a_changed_byte_in_a_later_segment_is_found(folder: Path, tmp_path: Path) -> None:
    data = (folder / "hal-4.mcap").read_bytes()
    place = data.index(b'"late_us":') - 3
    path = tmp_path / "hal-4.mcap"
    path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])
    assert load_trace(path).file.damaged


def with_header(trace: ProgramTrace, **changed: Any) -> ProgramTrace:
    content = trace.content(0) | changed
    record = replace(trace.file.records[0], data=json.dumps(content).encode())
    file = replace(trace.file, records=(record, *trace.file.records[1:]))
    return replace(trace, header=replace(trace.header, **changed), file=file)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"run": "0123456789abcdef"}, "the trace right before it is of another run"),
        ({"follows": False}, "this one is not its successor"),
        ({"segment": 1}, "there is a state with which a later one begins"),
        ({"segment": 4}, "others are missing"),
        ({"segment": 0}, "they are counted from 1 on"),
        ({"gap": Gap(10**12, 1, "full")}, "nothing is missing before this segment, and that records are"),
    ],
)
def test_a_changed_header_is_found_in_the_row(
    segments: tuple[ProgramTrace, ...], changed: dict[str, Any], said: str
) -> None:
    content = {key: asdict(value) if key == "gap" else value for key, value in changed.items()}
    third = replace(with_header(segments[2], **content), header=replace(segments[2].header, **changed))
    found = in_a_row((*segments[:2], third))
    assert not found[2].ok
    assert any(said in each.what for each in found[2].objections), found[2].objections


YEAR_2038 = 2_147_483_647_000_000
JUMPS = [YEAR_2038, 2**63 - 1, 2**80, 0, -1, -(2**63), 1.5, float("nan"), float("inf"), "now", None, 10**400]


def outcome(trace: ProgramTrace) -> str:
    """What is said of a trace, in words."""
    try:
        found = review(trace)
    except UsageError as error:
        return str(error)
    return "" if found.ok else str(found.replay.difference or found.objections[0])


@pytest.mark.parametrize(
    ("kind", "key", "jump"),
    [
        pytest.param(*place, jump, id=f"{'-'.join(place)}-{jump!r:.12}", marks=marks)
        for place in (("frame", "stamp"), ("frame", "at"), ("time", "at"), ("command", "at"))
        for number, jump in enumerate(JUMPS)
        # each jump at one place, and each place with one jump ahead, one back and one that is no number
        for marks in ([] if place[1] == "stamp" or number in (0, 4, 9) else [pytest.mark.thinned],)
    ],
)
def test_a_jump_of_a_stamp_is_found_and_ends(
    gripped: ProgramTrace, kind: str, key: str, jump: object
) -> None:
    middle = numbers(gripped, kind)[len(numbers(gripped, kind)) // 2]

    def jumps(content: dict[str, Any]) -> None:
        content[key] = jump

    said = outcome(edited(gripped, middle, jumps))
    backwards = key == "at" and type(jump) is int and jump <= 0
    assert said or backwards, "what comes late counts as coming now"
    assert "Traceback" not in said


def test_a_frame_of_2038_in_a_trace_is_refused_again(gripped: ProgramTrace) -> None:
    middle = numbers(gripped, "frame")[40]
    said = outcome(edited(gripped, middle, lambda content: content.update(stamp=YEAR_2038)))
    assert said.startswith("status: recorded nothing, replayed"), "the alarm that it was refused"


TOOL = """
name: jaw_tool
link: {port: /dev/ttyUSB0}
sequence: [jaw]
actuators: {jaw: {kind: gripper, line: JAW, open_bit: cylinder_retracted, closed_bit: cylinder_extended, timeout_s: 2}}
tool_changer: {line: UNLOCK}
supply: {channel: none}
"""


def test_it_is_over_long_before_its_time_out(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(TOOL, encoding="utf-8")
    tool = RecordedTool(tmp_path, "no-part:jaw", description=load_tool(path))
    tool.play(1.5, "grip", 5.0)
    times = [at for at, line, _ in tool.edges if line == "JAW"]
    lengths = [end - begin for begin, end in zip(times[::2], times[1::2], strict=True)]
    assert len(lengths) == 3
    assert max(lengths) < 1_000_000
    error = next(status for status in tool.statuses if status.ee is EndEffectorState.GRIP_ERROR)
    assert error.cause is Cause.EMPTY
    assert tool.status.ee is EndEffectorState.STAND_BY
    found = review(tool.trace())
    assert found.ok, found.as_json()
    assert found.replay.inputs > 100
