"""The thread that gives the commands of ``eehal run``, and its prompt, where the system has no memory left."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.cli.run import _simulation
from end_effector_hal.cli.run._causes import Causes
from end_effector_hal.cli.run._session import CommandThread, Prompt
from end_effector_hal.cli.run._voices import Changes, JsonLines
from end_effector_hal.control import network_of
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import MissingExtraError, ReportedError, UsageError
from end_effector_hal.runtime.boundary import RecordedController, Recorder, entry_of
from end_effector_hal.wires import PipedLines
from end_effector_lab.demo import World
from tests.support.virtual_tool import VirtualTool
from tests.unit.conftest import Whole


def test_a_step_that_fails_ends_itself_only() -> None:
    ended, worked = threading.Event(), threading.Event()

    def fails() -> Iterator[None]:
        yield
        raise MemoryError

    def works() -> Iterator[None]:
        while not ended.wait(0.0):
            yield
        worked.set()

    commands = CommandThread()
    for steps in (works(), fails(), fails()):
        commands.give(steps)
    ended.set()
    assert worked.wait(10.0)
    assert commands.alive()


def test_a_line_that_finds_no_memory_is_refused_and_the_next_one_is_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lines: list[str | type[Exception]] = [MemoryError, "grip", EOFError]

    def read(_: PipedLines) -> str:
        line = lines.pop(0)
        if isinstance(line, str):
            return line
        raise line

    monkeypatch.setattr(PipedLines, "next", read)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(fileno=int))
    monkeypatch.setattr("time.sleep", lambda _: None)
    refused: list[ReportedError] = []
    assert len(list(Prompt(shown=False).commands(refused.append))) == 1
    assert ["not enough memory" in str(error) for error in refused] == [True]


TOOL = load(profile_path())


def test_without_it_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_simulation, "lab_installed", lambda: False)
    with pytest.raises(MissingExtraError) as refused, _simulation.simulated(TOOL, "nominal"):
        pass
    assert str(refused.value) == (
        "--simulate needs the extra lab, which is not installed. "
        "Install it: pip install '.[lab]' in a checkout of end-effector-hal."
    )
    assert list(_simulation.possible_scenarios(TOOL)) == []


def test_a_scenario_that_the_tool_cannot_have_is_refused_before_anything_is_started(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no fault is named 'leek'\. Did you mean 'leak'"):
        World(TOOL, "leek:cylinder", tmp_path)
    assert list(tmp_path.iterdir()) == []


def refused(whole: Whole, *options: str) -> str:
    """What `eehal run` says of a usage error."""
    code, _, err = whole("run", profile_path(), *options)
    assert code == 2
    return err


def test_what_is_not_simulated_has_no_seed(whole: Whole) -> None:
    said = refused(whole, "--seed", "3")
    assert said == "--seed is for a simulated tool: a real one has nothing random. Add --simulate.\n"
    assert "-1 is not in the range" in refused(whole, "--simulate", "--seed", "-1")


@pytest.mark.parametrize("options", [("--scenario", "nominal"), ("--script", "lock; scenario supply:300")])
def test_what_is_not_simulated_has_no_scenario(options: tuple[str, ...], whole: Whole) -> None:
    assert refused(whole, *options) == (
        "A scenario is for a simulated tool: nothing makes a real one fail. Add --simulate.\n"
    )


def played(description: Description, causes: Causes, scenario: str, seconds: float) -> VirtualTool:
    tool = VirtualTool(
        description,
        scenario,
        controller=lambda d, n: RecordedController(d, n, lambda record: causes.take(*entry_of(record))),  # type: ignore[arg-type,return-value]
    )
    tool.play(1.0, "grip", seconds)
    return tool


def the(entries: list[dict[str, Any]], text: str) -> dict[str, Any]:
    return next(entry for entry in entries if text in entry["text"])


def test_a_confirmation_names_its_event_its_edge_and_what_the_sensor_said(verdin: Description) -> None:
    causes = Causes(verdin)
    played(verdin, causes, "nominal", 5.0)
    entries = list(causes.new())
    extended = the(entries, "Cylinder EXTENDED")
    assert extended["kind"] == "transition"
    assert extended["cause"] == "confirmed[1]"
    assert [(edge["process"], edge["target"]) for edge in extended["edges"]] == [
        ("Actuator(1)", "Confirming"),
        ("Actuator(1)", "On"),
        ("Gripper", "Activate"),
    ]
    assert extended["readings"]["cylinder_extended"] is True
    pending = the(entries, "Cylinder PENDING EXTEND")
    assert pending["readings"]["cylinder_extended"] is False
    assert abs(pending["readings"]["cylinder"]) < 50  # kPa
    assert pending["at"] < extended["at"]
    assert list(causes.new()) == []


def test_a_time_out_has_the_guard_of_its_clock_and_no_event(verdin: Description) -> None:
    causes = Causes(verdin)
    played(verdin, causes, "never-confirms:cylinder", 7.0)
    late = next(entry for entry in causes.new() if entry["kind"] == "time-out")
    assert late["cause"] is None
    assert any(">=" in edge.get("guard", "") for edge in late["edges"])
    assert late["readings"]["cylinder"] < 50


def test_what_is_stale_is_no_reading(verdin: Description) -> None:
    causes = Causes(verdin)
    tool = played(verdin, causes, "nominal", 5.0)
    list(causes.new())
    tool.link = False
    tool.play(0.5, "drop")
    (begun,) = [entry for entry in causes.new() if "RELEASING" in entry["text"]]
    assert begun["cause"] == "drop"
    assert set(begun["readings"].values()) == {None}


def test_it_stands_before_the_states_that_it_led_to(
    verdin: Description, capsys: pytest.CaptureFixture[str]
) -> None:
    causes = Causes(verdin)
    tool = played(verdin, causes, "nominal", 0.1)
    changes = Changes(verdin, JsonLines(0), causes)
    changes.status(next(status for status in tool.statuses if status.events))
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    kinds = [each["event"] for each in events]
    assert kinds[0] == "transition"
    assert kinds.index("log") == kinds.count("transition")
    assert {"text", "kind", "cause", "edges", "changes", "late_ms", "readings"} <= events[0].keys()
    assert "at" not in events[0]


def test_who_looks_on_and_fails_ends_no_program(verdin: Description) -> None:
    calls = []

    def fail(kind: str, _at: int, _record: object) -> None:
        calls.append(kind)
        raise RuntimeError("not today")

    recorder = Recorder(observe=fail)
    controller = recorder.controller(verdin, network_of(verdin))
    controller.start({}, 0)
    controller.advance(1_000_000)
    assert len(calls) == 1
