"""What was recorded is decided the same once more, and is a run of the network; whatever was changed is found."""

from __future__ import annotations

import inspect
import json
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import click
import pytest

from end_effector_hal.cli._replay import _tell
from end_effector_hal.control import Controller
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.runtime.boundary import RecordedController
from end_effector_hal.verification.replay import ProgramTrace, _load, load_trace, review
from end_effector_hal.vocabulary import Command
from end_effector_lab.demo import scenarios
from tests.support.nightly import examples, first_of
from tests.support.recorded_tool import RecordedTool
from tests.unit.verification.replay.conftest import Edit, edited, numbers

SCENARIOS = {each.name: each for each in scenarios(load(profile_path()), everything=True)}
WORDS = {
    Command.LOCK: "lock", Command.UNLOCK: "unlock", Command.GRIP: "grip", Command.RELEASE: "drop",
    Command.CANCEL: "cancel",
}  # fmt: skip
TELLING = {"start", "command", "begin", "write", "event", "step", "answer", "status"}
QUESTIONS = {
    "announce_to", "at", "blocking", "deadline", "discrete_state", "foresee", "hold", "locations", "refusal",
    "refuse_maintenance", "senses", "snapshot", "status",
}  # fmt: skip
"""What changes nothing in a controller, and so is not recorded."""


@pytest.mark.parametrize(
    "name", first_of(sorted(SCENARIOS, key=lambda name: (name != "cancel", name != "fails-once")), 1, 1)
)
def test_each_scenario_of_the_demo_decides_the_same(tool: Callable[..., RecordedTool], name: str) -> None:
    scenario = SCENARIOS[name]
    played = tool(scenario.bench)
    played.run(1.0 + scenario.rest_s)
    for order in scenario.orders:
        assert played.command(WORDS[order.command]).accepted
        played.run(order.wait_s)
        while not order.background and played.status.command != Command.NONE:
            played.run(0.5)
        if not order.background:
            played.run(25.0)
    found = review(played.trace())
    assert found.ok, found.as_json()
    assert found.replay.inputs > 100
    assert found.replay.compared == sum(
        len(numbers(found.trace, kind)) for kind in ("begin", "write", "event", "step", "answer", "status")
    )
    assert found.objections == ()
    assert found.steps == len(numbers(found.trace, "step")) > 0
    assert found.requirements > 0
    assert found.notes == ()


def test_lines_that_were_found_active_and_a_refused_command(tool: Callable[..., RecordedTool]) -> None:
    played = tool(levels={"SODIMM_208": True})
    played.run(3.0)
    assert not played.command("grip").accepted
    played.run(1.0)
    assert review(played.trace()).ok


def test_a_silent_link_is_replayed_too(tool: Callable[..., RecordedTool]) -> None:
    played = tool()
    played.play(1.0, "grip", 3.0)
    played.link = False
    played.run(2.0)
    played.link = True
    played.run(1.0)
    assert review(played.trace()).ok


def test_every_input_of_a_controller_is_recorded() -> None:
    """A new one must be recorded, or be a question; else its replay would differ."""
    public = {name for name, _ in inspect.getmembers(Controller) if name.islower() and name[0] != "_"}
    public.remove("resume")  # only a replay does, from the state with which a segment begins
    public.remove(
        "pass_over"
    )  # only in virtual time that leaves frames out: the monitor judges it, nobody replays it
    methods = {name: each for name, each in vars(RecordedController).items() if inspect.isfunction(each)}
    recorded = {name for name in public & methods.keys() if "_put" in methods[name].__code__.co_names}
    assert public - recorded == QUESTIONS


def seconds(trace: ProgramTrace, number: int) -> float:
    return trace.seconds(trace.content(number)["at"])


def difference_of(trace: ProgramTrace) -> tuple[float, str]:
    found = review(trace)
    assert not found.ok
    return trace.seconds(found.replay.difference.at), str(found.replay.difference)


def test_one_frame_changed_is_found_with_its_time(gripped: ProgramTrace) -> None:
    """The vacuum is there a frame earlier than it was."""
    confirming = numbers(gripped, "event", lambda content: content["channel"] == "confirmed[0]")[0]
    before = [number for number in numbers(gripped, "frame") if number < confirming]
    changed = edited(gripped, before[-4], lambda content: content["values"].update(bottom=-80_000))
    at, text = difference_of(changed)
    assert at == pytest.approx(seconds(gripped, before[-2]))
    assert "confirmed[0]" in text


def test_one_step_removed_is_found_with_its_time(gripped: ProgramTrace) -> None:
    for number in numbers(gripped, "step")[::6]:
        without = edited(gripped, number, None)
        found = review(without)
        at = gripped.seconds(found.replay.difference.at)
        assert at == pytest.approx(seconds(gripped, number), abs=0.021)
        assert any(objection.kind == "no run" for objection in found.objections)


@pytest.mark.parametrize(
    ("kind", "edit"),
    [
        ("start", lambda content: content["levels"].update(SODIMM_208=True)),
        ("command", lambda content: content.update(name="cancel")),
        ("answer", lambda content: content.update(accepted=False)),
        ("event", lambda content: content.update(channel="gone[2]")),
        ("step", lambda content: content.update(late_us=1)),
        ("step", lambda content: content.update(missed=True)),
        ("step", lambda content: content["edges"][0].update(index=99)),
        ("status", lambda content: content.update(ee=5)),
        ("status", lambda content: content["evidence"].reverse() or content["evidence"].append(0)),
    ],
)
def test_whatever_is_changed_is_found(gripped: ProgramTrace, kind: str, edit: Edit) -> None:
    number = numbers(gripped, kind)[-1]
    difference_of(edited(gripped, number, edit))


@pytest.mark.parametrize("kind", ["start", "command", "answer", "event", "step", "status"])
def test_whatever_is_left_out_is_found(gripped: ProgramTrace, kind: str) -> None:
    difference_of(edited(gripped, numbers(gripped, kind)[0], None))


def test_what_is_no_record_is_refused(gripped: ProgramTrace) -> None:
    broken = edited(gripped, numbers(gripped, "frame")[5], lambda content: content.update(stamp="soon"))
    with pytest.raises(UsageError, match=r"Record \d+ \(frame\) cannot be read: stamp: "):
        review(broken)


def test_a_missed_bound_stands_in_the_trace_and_is_no_difference(tool: Callable[..., RecordedTool]) -> None:
    played = tool("never-confirms:bottom_vacuum")
    played.play(1.0, "grip", 4.9)
    played.controller.advance(6_000_000 + 63_000)
    played.at = 6_063_000
    played.run(1.0)
    found = review(played.trace())
    assert found.ok
    (missed,) = found.objections
    assert (missed.kind, missed.at) == ("missed", 6_063_000)
    assert "63.000 ms late" in missed.what
    steps = [found.trace.content(number) for number in numbers(found.trace, "step")]
    assert [(step["late_us"], step["missed"]) for step in steps if step["missed"]] == [(63_000, True)]


def test_a_controller_that_begins_anew_is_replayed_anew(tool: Callable[..., RecordedTool]) -> None:
    """As a program does that the line arbiter took for dead."""
    played = tool()
    played.play(1.0, "grip", 2.0)
    network = played.controller._controller._execution.network
    played.controller = played.recorder.controller(played.description, network)
    played.controller.start(dict(played.levels), played.at)
    played.run(1.0)
    found = review(played.trace())
    assert found.ok, found.as_json()
    assert len(numbers(found.trace, "start")) == 2


def test_another_description_decides_otherwise_and_says_so(gripped: ProgramTrace, tmp_path: Any) -> None:
    text = profile_path().read_text()
    path = tmp_path / "end_effector.yaml"
    path.write_text(text.replace("    kind: cylinder\n", "    kind: cylinder\n    timeout_s: 2.0\n"))
    found = review(gripped, load(path))
    assert not found.ok
    assert "Replayed with another description" in " ".join(found.notes)
    assert "T_CONFIRM" in " ".join(found.notes)


def test_arbitrary_damage_is_found_or_refused_in_words(tool: Callable[..., RecordedTool]) -> None:
    """Never a traceback, whatever stands in a record."""
    played = tool()
    played.play(0.5, "grip", 0.5)
    trace, chooser, found = played.trace(), random.Random(1), set()
    telling = [
        number for number in range(len(trace.file.records)) if trace.file.records[number].kind in TELLING
    ]
    for _ in range(20):
        damaged = edited(trace, chooser.choice(telling), lambda content: damage(chooser, content))
        try:
            json.dumps(review(damaged).as_json())
            found.add("judged")
        except UsageError:
            found.add("refused")
    assert found == {"judged", "refused"}


DAMAGE = (None, -1, 0, 10**30, "x", "", [], {}, True, 1.5, [[]], {"a": 1})
HOSTILE = (
    float("nan"), float("inf"), 10**400, -(10**30), 2**63, "\ud800", "9" * 5_000, [], [[1]], {"at": []}, None, True,
)  # fmt: skip


def test_hostile_records_get_sentences(
    gripped: ProgramTrace, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of every kind, the header too, from the file to what is printed; a list as deep as a stack is."""
    chooser, found = random.Random(2), set()
    kinds = sorted({record.kind for record in gripped.file.records})
    for turn in range(examples(40, 1_000)):
        kind = kinds[turn % len(kinds)]
        number = chooser.choice([n for n, record in enumerate(gripped.file.records) if record.kind == kind])
        hostile = edited(gripped, number, lambda content: damage(chooser, content, HOSTILE))
        if turn % 10 == 9:
            deep = b'{"at": ' + b"[" * 20_000 + b"]" * 20_000 + b"}"
            records = [*hostile.file.records]
            records[number] = replace(records[number], data=deep)
            hostile = replace(hostile, file=replace(hostile.file, records=tuple(records)))
        monkeypatch.setattr(_load, "read_trace", lambda _, file=hostile.file: file)
        try:
            judged = review(load_trace(gripped.file.path))
            json.dumps(judged.as_json())
            _tell(judged)
            found.add("judged")
        except UsageError as error:
            click.echo(str(error))
            found.add("refused")
    assert found == {"judged", "refused"}
    assert capsys.readouterr().out.encode()


def damage(
    chooser: random.Random, content: dict[str, Any] | list[Any], values: Sequence[object] = DAMAGE
) -> None:
    """One value of a record, somewhere in its depths, becomes something else."""
    key = chooser.choice([*content] if isinstance(content, dict) else range(len(content)))
    value = content[key]
    if isinstance(value, dict | list) and value and chooser.random() < 0.8:
        damage(chooser, value, values)
    else:
        content[key] = chooser.choice(values)
