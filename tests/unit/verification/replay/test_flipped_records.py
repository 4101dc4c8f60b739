"""Each value of a header, a step, a write and a restart, changed: it is objected to, without any replay.

What no objection finds is named, with the reason; a replay finds some of that.
"""

from __future__ import annotations

import json
import random
from dataclasses import replace
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from end_effector_hal.errors import UsageError
from end_effector_hal.runtime.boundary import KINDS
from end_effector_hal.verification.replay import ProgramTrace, _review, review
from end_effector_hal.verification.replay._replay import Replay
from end_effector_hal.verification.replay._review import Review
from tests.support.flips import Path, flips
from tests.support.nightly import examples
from tests.support.recorded_lines import RecordedLinesTool

pytestmark = pytest.mark.thinned  # long

UNFOUND = {
    ("header", "version"): "nothing else in a trace says which version wrote it; no decision rests on it",
    ("header", "source"): "where the description stood on another machine; it is asked for a note only",
    ("header", "run"): "a random word; in a row of segments it is found (test_segments)",
    ("header", "segment"): "one that begins before the lines are adopted has no state; found in a row",
    ("lines", "took_us"): "how long a write took is measured, and follows from nothing",
    ("lines", "error"): "what a line arbiter answers is measured, too; after an error more is excused",
    ("start", "sensor_fault"): "the automata ask for it when they adopt the lines; a replay finds this",
    ("start", "grip_error"): "without an active line it changes nothing; else a replay finds this",
    ("start", "part"): "a tool that names no parts has no other one; else a replay finds this",
    ("start", "levels"): "plain outputs stand there, too; what the first start finds, the replay judges",
}
"""Why a changed value is no objection; by kind and key."""
LINES = ("SODIMM_208", "SODIMM_210", "SODIMM_212")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> ProgramTrace:
    """Maintenance, a grip that a death ends, a grip whose cylinder fails once, a held part at a death, a Drop."""
    tool = RecordedLinesTool(tmp_path_factory.mktemp("flipped"), "fails-once:cylinder")
    tool.run(0.4)
    tool.drive(LINES[2], active=True)
    tool.run(0.1)
    tool.drive(LINES[2], active=False)
    tool.play(0.3, "grip", 0.6)
    tool.die()
    tool.play(4.0, "grip", 1.5)
    tool.die()
    tool.play(0.3, "drop", 0.1)
    tool.die()
    tool.run(1.0)
    return tool.trace()


def objections(trace: ProgramTrace, monkeypatch: pytest.MonkeyPatch) -> Review:
    """A review that replays nothing."""
    monkeypatch.setattr(_review, "replay", lambda *_: Replay(0, 0, None))
    return review(trace)


def test_what_was_recorded_is_not_objected_to(recorded: ProgramTrace) -> None:
    found = review(recorded)
    assert found.ok, found.as_json()
    assert found.objections == ()
    assert {record.kind for record in recorded.file.records} >= {"header", "start", "step", "lines"}


def changed(trace: ProgramTrace, kinds: tuple[str, ...]) -> list[tuple[int, Path, dict[str, Any]]]:
    """Each change that means something else, of each record of these kinds."""
    found = []
    for number, record in enumerate(trace.file.records):
        if record.kind in kinds:
            before = trace.typed(number)
            for path, content in flips(record.content):
                if typed(record.kind, content) not in (None, before):
                    found.append((number, path, content))
    return found


def typed(kind: str, content: dict[str, Any]) -> object:
    """None: it is refused as no such record."""
    try:
        return TypeAdapter(KINDS[kind]).validate_json(json.dumps(content))
    except ValidationError:
        return None


def with_record(trace: ProgramTrace, number: int, content: dict[str, Any]) -> ProgramTrace:
    records = list(trace.file.records)
    records[number] = replace(records[number], data=json.dumps(content).encode())
    header = typed("header", json.loads(records[0].data))
    return replace(trace, header=header, file=replace(trace.file, records=tuple(records)))


@pytest.mark.parametrize("kinds", [("header",), ("start",), ("step",), ("lines",)])
def test_whatever_is_changed_is_objected_to(
    recorded: ProgramTrace, monkeypatch: pytest.MonkeyPatch, kinds: tuple[str, ...]
) -> None:
    all_changes = changed(recorded, kinds)
    assert len(all_changes) > 20
    some = random.Random(4).sample(all_changes, min(len(all_changes), examples(25, len(all_changes))))
    for number, path, content in some:
        try:
            found = objections(with_record(recorded, number, content), monkeypatch)
        except UsageError:
            continue
        said = [each.what for each in found.objections if each.kind == "no run"]
        assert said or (kinds[0], path[0]) in UNFOUND, (number, path, content)


@pytest.mark.parametrize("constant", ["D", "T_CONFIRM", "DEATH_KEEPS", "RELEASE_ORDER", "BLOWS"])
def test_a_header_with_another_constant(
    recorded: ProgramTrace, monkeypatch: pytest.MonkeyPatch, constant: str
) -> None:
    content = recorded.content(0)
    del content["constants"][constant]
    (found,) = objections(with_record(recorded, 0, content), monkeypatch).objections
    assert f"nothing of {constant}" in found.what
    content["constants"][constant] = 4711
    (found,) = objections(with_record(recorded, 0, content), monkeypatch).objections
    assert f"{constant} = 4711" in found.what


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("description", "other", "that the tool is 'other'"),
        ("hash", "0" * 12, "that description and automata are '000000000000'"),
        ("model", "0" * 12, "that the UPPAAL file is '000000000000'"),
        ("at", -1, "Record 0 (header) has another time than its message, by 1 µs"),
        ("started", "2026-01-01T00:00:00+00:00", "is not the time of day of its message"),
        ("started", "soon", "is invalid: 'soon'"),
        ("follows", True, "that the first segment follows another one"),
    ],
)
def test_a_header_that_says_something_else(
    recorded: ProgramTrace, monkeypatch: pytest.MonkeyPatch, key: str, value: object, said: str
) -> None:
    changed_one = with_record(recorded, 0, recorded.content(0) | {key: value})
    (found,) = objections(changed_one, monkeypatch).objections
    assert said in found.what


@pytest.mark.parametrize("where", ["{path}:1:1", "/elsewhere.xml:{place}", "", "x"])
def test_an_edge_that_stands_elsewhere(
    recorded: ProgramTrace, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    number = [n for n, record in enumerate(recorded.file.records) if record.kind == "step"][3]
    content = recorded.content(number)
    path, _, place = content["edges"][0]["where"].partition(":")
    content["edges"][0]["where"] = where.format(path=path, place=place)
    (found,) = objections(with_record(recorded, number, content), monkeypatch).objections
    assert "is recorded " in found.what


def test_an_edge_that_leads_elsewhere_is_not_followed(
    recorded: ProgramTrace, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Target, source, index and process: the monitor says so, and goes on as the network does."""
    steps = [n for n, record in enumerate(recorded.file.records) if record.kind == "step"]
    whole = objections(recorded, monkeypatch).steps
    for number in steps[:: examples(9, 1)]:
        for key, value in (("target", "StandBy"), ("source", "Nowhere"), ("index", 0), ("index", -1)):
            content = recorded.content(number)
            if content["edges"][0][key] == value:
                continue
            content["edges"][0][key] = value
            found = objections(with_record(recorded, number, content), monkeypatch)
            assert any(each.kind == "no run" for each in found.objections), content
            assert found.steps == whole, content
