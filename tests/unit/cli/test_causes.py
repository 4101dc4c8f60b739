"""`eehal run --json`: why the automata did what they did, with guard, event and readings."""

from __future__ import annotations

import json
from typing import Any

import pytest

from end_effector_hal.cli.run._causes import Causes
from end_effector_hal.cli.run._voices import Changes, JsonLines
from end_effector_hal.control import network_of
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.runtime.boundary import RecordedController, Recorder, entry_of
from tests.support.virtual_tool import VirtualTool


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def played(description: Description, causes: Causes, scenario: str, seconds: float) -> VirtualTool:
    tool = VirtualTool(
        description,
        scenario,
        controller=lambda d, n: RecordedController(d, n, lambda record: causes.take(*entry_of(record))),  # type: ignore[arg-type,return-value]
    )
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(seconds)
    return tool


def the(entries: list[dict[str, Any]], text: str) -> dict[str, Any]:
    return next(entry for entry in entries if text in entry["text"])


def test_a_confirmation_names_its_event_its_edge_and_what_the_sensor_said(description: Description) -> None:
    causes = Causes(description)
    played(description, causes, "nominal", 5.0)
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


def test_a_time_out_has_the_guard_of_its_clock_and_no_event(description: Description) -> None:
    causes = Causes(description)
    played(description, causes, "never-confirms:cylinder", 7.0)
    late = next(entry for entry in causes.new() if entry["kind"] == "time-out")
    assert late["cause"] is None
    assert any(">=" in edge.get("guard", "") for edge in late["edges"])
    assert late["readings"]["cylinder"] < 50


def test_what_is_stale_is_no_reading(description: Description) -> None:
    causes = Causes(description)
    tool = played(description, causes, "nominal", 5.0)
    list(causes.new())
    tool.link = False
    tool.run(0.5)
    assert tool.command("drop").accepted
    (begun,) = [entry for entry in causes.new() if "RELEASING" in entry["text"]]
    assert begun["cause"] == "drop"
    assert set(begun["readings"].values()) == {None}


def test_it_stands_before_the_states_that_it_led_to(
    description: Description, capsys: pytest.CaptureFixture[str]
) -> None:
    causes = Causes(description)
    tool = played(description, causes, "nominal", 0.1)
    changes = Changes(description, JsonLines(0), causes)
    changes.status(next(status for status in tool.statuses if status.events))
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    kinds = [each["event"] for each in events]
    assert kinds[0] == "transition"
    assert kinds.index("log") == kinds.count("transition")
    assert {"text", "kind", "cause", "edges", "changes", "late_ms", "readings"} <= events[0].keys()
    assert "at" not in events[0]


def test_who_looks_on_and_fails_ends_no_program(description: Description) -> None:
    calls = []

    def fail(kind: str, _at: int, _record: object) -> None:
        calls.append(kind)
        raise RuntimeError("not today")

    recorder = Recorder(observe=fail)
    controller = recorder.controller(description, network_of(description))
    controller.start({}, 0)
    controller.advance(1_000_000)
    assert len(calls) == 1
