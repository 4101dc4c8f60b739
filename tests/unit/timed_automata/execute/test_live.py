"""The lamp of examples/lamp in virtual time, on lines that a simulated finger presses: exact to the microsecond."""

from __future__ import annotations

import runpy
import sys
import time
from collections.abc import Iterator
from typing import Any

import gpiod
import pytest
from gpiod.line import Direction, Edge, Value

from tests.support.places import DOCS, ROOT
from tests.unit.timed_automata.test_page import MODEL
from timed_automata import Event, Execution, live, load_network

LAMP = ROOT / "examples/lamp"
BUTTON_LINE, LAMP_LINE = 17, 27


class Over(Exception):
    """The finger is tired."""


class Bench:
    """Two lines of a chip, in virtual time; the button is pressed at some instants, in µs."""

    def __init__(self, presses: list[int]) -> None:
        self.now, self.presses, self.levels = 0, presses, [(0, 0)]

    def clock_us(self) -> int:
        return self.now

    def wait_edge_events(self, seconds: float | None) -> bool:
        limit = None if seconds is None else self.now + round(seconds * 1e6)
        if self.presses and (limit is None or self.presses[0] <= limit):
            self.now = self.presses[0]
            return True
        if limit is None:
            raise Over
        self.now = limit
        return False

    def read_edge_events(self) -> None:
        self.presses.pop(0)

    def set_value(self, line: int, value: Value) -> None:
        assert line == LAMP_LINE
        if value.value != self.levels[-1][1]:
            self.levels.append((self.now, value.value))


def lit(execution: Execution, bench: Bench) -> Iterator[tuple[int, int]]:
    def wait(seconds: float | None) -> Event | None:
        if not bench.wait_edge_events(seconds):
            return None
        bench.read_edge_events()
        return Event("press")

    try:
        for steps in live(execution, bench.clock_us, wait):
            yield bench.now, len(steps)
    except Over:
        return


def test_every_event_and_every_deadline_yields_its_steps() -> None:
    execution = Execution(load_network(LAMP / "lamp.xml"), ["Lamp"])
    # the second press finds the lamp lit: no edge takes it
    assert list(lit(execution, Bench([1_500_000, 3_000_000]))) == [
        (0, 0), (1_500_000, 1), (3_000_000, 0), (6_500_000, 1),
    ]  # fmt: skip


def test_the_program_of_the_page_lights_the_lamp(monkeypatch: pytest.MonkeyPatch) -> None:
    bench, asked = Bench([1_500_000, 9_000_000]), {}

    def request_lines(path: str, *, consumer: str, config: dict[int, Any]) -> Bench:
        asked.update(config)
        return bench

    monkeypatch.setattr(gpiod, "request_lines", request_lines)
    monkeypatch.setattr(time, "monotonic_ns", lambda: bench.now * 1000)
    monkeypatch.setattr(sys, "argv", ["lamp.py", "/dev/gpiochip0", str(BUTTON_LINE), str(LAMP_LINE)])
    with pytest.raises(Over):
        runpy.run_path(str(LAMP / "lamp.py"))
    assert asked[BUTTON_LINE].edge_detection is Edge.FALLING
    assert asked[LAMP_LINE].direction is Direction.OUTPUT
    assert bench.levels == [(0, 0), (1_500_000, 1), (6_500_000, 0), (9_000_000, 1), (14_000_000, 0)]


def test_the_pages_show_these_files() -> None:
    assert (LAMP / "lamp.xml").read_text(encoding="utf-8") == MODEL[1]
    page = (DOCS / "tutorials/my-own-model.md").read_text(encoding="utf-8")
    loop = page.partition("```python\n")[2].partition("```")[0]
    assert (LAMP / "lamp.py").read_text(encoding="utf-8").endswith(loop)
