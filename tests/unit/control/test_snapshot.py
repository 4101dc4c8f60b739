"""A controller that goes on where another one stood decides the same, wherever it is cut."""

from __future__ import annotations

import copy
import json
from collections import deque
from collections.abc import Iterator
from functools import cache
from typing import Any

import pytest
from pydantic import TypeAdapter
from pydantic_core import to_json

from end_effector_hal.control import Controller, ControllerSnapshot, network_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.signals._memory import INLINE, NESTED
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool
from timed_automata import Network

DESCRIPTION = load(profile_path())
READ = TypeAdapter(ControllerSnapshot).validate_json
PIECE_S = 0.13
PLAIN = (bool, int, float, str, tuple, list, dict, frozenset, set, deque, type(None))
CACHED = {
    "fresh", "_ends", "_due", "_seen", "_refused", "_down", "_outages", "_stale", "_notices", "_vacant",
    "_changer_fault", "_kept",
}  # fmt: skip
"""What a status looks up once for an instant, or follows from what is remembered."""


@cache
def network() -> Network:
    return network_of(DESCRIPTION)


def written(controller: Controller) -> bytes:
    return to_json(controller.snapshot(), fallback=dict)


def resumed(controller: Controller) -> Controller:
    """Another one, from what stands in a file."""
    other = Controller(DESCRIPTION, network())
    other.resume(READ(written(controller)))
    assert written(other) == written(controller)
    return other


class Cut(VirtualTool):
    """Its controller is replaced all the time."""

    def run(self, seconds: float) -> None:
        until = self.at + round(seconds * 1e6)
        while self.at < until:
            super().run(min(PIECE_S, (until - self.at) / 1e6))
            self.controller = resumed(self.controller)


def play(tool: VirtualTool) -> VirtualTool:
    """A grip with a failed attempt, a silence while it is held, a Drop; a cancelled grip; unlock and lock."""
    tool.run(1.0)
    tool.command("grip")
    tool.run(8.0)
    tool.link = False
    tool.run(1.5)
    tool.link = True
    tool.run(3.0)
    for word, seconds in (("drop", 3.0), ("grip", 1.0), ("cancel", 4.0), ("unlock", 4.0), ("lock", 3.0)):
        tool.command(word)
        tool.run(seconds)
    return tool


@pytest.mark.parametrize(
    "scenario",
    first_of(["fails-once:cylinder", "leak:bottom_vacuum", "nominal", "never-confirms:top_vacuum"], 1, 1),
)
def test_wherever_it_is_cut_it_decides_the_same(scenario: str) -> None:
    whole = play(VirtualTool(DESCRIPTION, scenario))
    cut = play(Cut(DESCRIPTION, scenario))
    assert len(whole.statuses) > 40
    assert cut.statuses == whole.statuses
    assert cut.edges == whole.edges


def parts(thing: Any, where: str) -> Iterator[tuple[str, Any]]:
    """Every object with a memory that can be reached."""
    if isinstance(thing, list | tuple):
        for number, each in enumerate(thing):
            yield from parts(each, f"{where}[{number}]")
    elif isinstance(thing, dict):
        for key, each in thing.items():
            yield from parts(each, f"{where}[{key}]")
    elif thing is not None:
        yield where, thing
        for name, kind in thing.MEMORY.items():
            if kind is NESTED or kind is INLINE:
                yield from parts(getattr(thing, name), f"{where}.{name}")


def rest(controller: Controller) -> dict[str, str]:
    """What stands in no memory, and so must not change."""
    return {
        f"{where}.{name}": f"{id(value)} {value!r}" if isinstance(value, PLAIN) else str(id(value))
        for where, thing in parts(controller, "controller")
        for name, value in vars(thing).items()
        if name not in thing.MEMORY and name not in CACHED
    }


def test_what_stands_in_no_memory_never_changes() -> None:
    tool = VirtualTool(DESCRIPTION, "fails-once:cylinder")
    before = rest(tool.controller)
    assert len(before) > 50
    play(tool)
    assert rest(tool.controller) == before


def test_a_snapshot_changes_nothing_and_there_is_none_before_the_start() -> None:
    assert Controller(DESCRIPTION, network()).snapshot() is None
    tool = VirtualTool(DESCRIPTION)
    tool.run(1.0)
    assert written(tool.controller) == written(tool.controller)


def broken(content: Any, *path: str | int) -> Any:
    """A copy with one value that cannot be."""
    content = copy.deepcopy(content)
    inner = content
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = "nonsense"
    return content


@pytest.mark.parametrize(
    "path",
    [
        ("execution", "locations", "Gripper"),
        ("execution", "locations", "Gripped"),
        ("memory", "_senses", "readings", "_values"),
        ("memory", "_senses", "_detectors", 0, "level"),
        ("memory", "_senses", "_detectors"),
        ("memory", "_hold", "_of_parts", 0, "0"),
        ("memory", "_hold", "_of_parts", 0, "7"),
        ("memory", "_statuses", "more"),
        ("memory", "_tool"),
    ],
)
def test_what_is_no_snapshot_is_refused_in_words(path: tuple[str | int, ...]) -> None:
    tool = VirtualTool(DESCRIPTION)
    tool.run(1.0)
    content = json.loads(written(tool.controller))
    other = Controller(DESCRIPTION, network())
    with pytest.raises(UsageError, match="A recorded state "):
        other.resume(READ(json.dumps(broken(content, *path))))


@pytest.mark.parametrize(
    ("name", "change"),
    [("variables", {"ee": 99}), ("variables", {"nothing": 0}), ("zeros", {"nothing": 0}), ("entered", 10**12)],
)  # fmt: skip
def test_a_state_that_the_network_cannot_have_is_refused(name: str, change: Any) -> None:
    tool = VirtualTool(DESCRIPTION)
    tool.run(1.0)
    content = json.loads(written(tool.controller))
    before = content["execution"][name]
    content["execution"][name] = before | change if isinstance(change, dict) else change
    with pytest.raises(UsageError, match="A recorded state "):
        Controller(DESCRIPTION, network()).resume(READ(json.dumps(content)))
