"""A program that works out ahead what it writes does what one does that works it out when it happens."""

from __future__ import annotations

import logging
from pathlib import Path
from random import Random
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime import InlineWorker
from end_effector_hal.runtime.outputs import LineWrite, Outputs
from end_effector_hal.runtime.programs._foresight import Foresight
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.virtual import VirtualTool, _tool
from tests.support.places import ROOT
from timed_automata import Event

SHIPPED = profile_path()
PARTS = ROOT / "examples/cells/three_parts/end_effector.yaml"
SCENARIOS = ("nominal", "fails-once:cylinder,flips:0.001", "lost-after:top_vacuum:2.5,sticks:bottom_vacuum")


class ForeseeingWorker(InlineWorker):
    """Works out what may come next, as the thread of a real program does while idle."""

    busy = False

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self._prepare = given[4]

    def _do_all(self) -> None:
        super()._do_all()
        while self._begun and not (self._busy or self._ended or self.busy) and self._prepare():
            pass


def story(description: Path, scenario: str, seed: int) -> tuple[object, ...]:
    """Play random commands; return all that the tool did."""
    tool, random = VirtualTool(load(description), scenario, seed=seed, models={}), Random(seed)
    tool.run(3.0)
    for _ in range(10):
        word = random.choice(("grip", "grip", "drop", "cancel", "lock", "unlock", "arm", "resume", "reset"))
        tool.command(word)
        tool.run(random.choice((0.05, 0.4, 1.7, 6.0)))
    return tuple(tool.edges), tuple(tool.statuses)


@pytest.fixture
def hastened(monkeypatch: pytest.MonkeyPatch) -> list[LineWrite]:
    """Let each program work out what comes; return the writes that it began before their statuses existed."""
    found: list[LineWrite] = []
    hasten = Outputs.hasten

    def counted(outputs: Outputs, write: LineWrite, at: int) -> None:
        found.append(write)
        hasten(outputs, write, at)

    monkeypatch.setattr(Outputs, "hasten", counted)
    monkeypatch.setattr(_tool, "InlineWorker", ForeseeingWorker)
    return found


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_it_does_the_same(
    scenario: str, seed: int, request: pytest.FixtureRequest, caplog: pytest.LogCaptureFixture
) -> None:
    usual = story(SHIPPED, scenario, seed)
    hastened: list[LineWrite] = request.getfixturevalue("hastened")
    assert story(SHIPPED, scenario, seed) == usual
    assert len(hastened) >= 3
    assert "foreseen" not in caplog.text


def test_parts_and_buses(request: pytest.FixtureRequest, caplog: pytest.LogCaptureFixture) -> None:
    usual = story(PARTS, "nominal", 1)
    hastened: list[LineWrite] = request.getfixturevalue("hastened")
    assert story(PARTS, "nominal", 1) == usual
    assert hastened
    assert "foreseen" not in caplog.text


def test_what_was_foreseen_in_another_state_is_not_written(
    hastened: list[LineWrite], monkeypatch: pytest.MonkeyPatch
) -> None:
    tool = VirtualTool(load(SHIPPED), models={})
    tool.run(3.0)
    monkeypatch.setattr(ForeseeingWorker, "busy", True)
    assert tool.command("unlock").accepted
    assert len(hastened) == 1
    tool.run(0.05)
    assert not tool.command("unlock").accepted
    assert len(hastened) == 1


def test_a_write_that_was_foreseen_wrongly_is_corrected(
    hastened: list[LineWrite], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.ERROR)
    tool = VirtualTool(load(SHIPPED), models={})
    tool.run(3.0)
    bottom, cylinder, top = (actuator.line for _, actuator in tool.description.ordered)
    of = Foresight.of

    def wrong(foresight: Foresight, event: Event, at: int) -> LineWrite | None:
        write = of(foresight, event, at)
        return write if write is None or hastened else write._replace(changes={top: True})

    monkeypatch.setattr(Foresight, "of", wrong)
    assert tool.command("grip").accepted
    assert "was foreseen, but the automata decided" in caplog.text
    tool.run(6.0)
    edges = [(edge.line, edge.level) for edge in tool.edges]
    assert edges == [(top, True), (bottom, True), (top, False), (cylinder, True), (top, True)]
    assert tool.status.ee is EndEffectorState.GRIPPED
