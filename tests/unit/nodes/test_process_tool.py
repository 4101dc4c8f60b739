"""Which tool a process of nodes has: one that it runs, or one that it talks to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes import start
from end_effector_hal.nodes.interface import Parameter


class Node:
    """A transport with parameters; it keeps what it is to call."""

    def __init__(self, description: Description, **parameters: str) -> None:
        self.description, self._parameters = lambda: description, parameters
        self.closers: list[Callable[[], None]] = []
        self.starters: list[Callable[[], None]] = []
        self.ticks: list[Callable[[], None]] = []
        self.failed: list[ReportedError] = []
        self.fail, self.on_close = self.failed.append, self.closers.append
        self.on_start = self.starters.append

    def parameter(self, parameter: Parameter) -> str:
        return self._parameters.get(parameter.name, "")

    def every(self, _rate_hz: float, callback: Callable[[], None]) -> None:
        self.ticks.append(callback)


@pytest.fixture(autouse=True)
def tools(monkeypatch: pytest.MonkeyPatch) -> None:
    """In place of the real ones."""
    for name in ("EndEffector", "RemoteTool"):

        def made(description: Description, name: str = name, **options: object) -> Any:
            tool = SimpleNamespace(kind=name, description=description, alive=True, **options)
            tool.start = tool.close = lambda: None
            return tool

        monkeypatch.setattr(start, name, made)


def opened(node: Node, *, hosts: bool) -> Any:
    return start.open_tool(cast("Any", node), hosts=hosts)


def test_hal_main_runs_the_tool_and_ends_with_it(verdin: Description, tmp_path: Path) -> None:
    node = Node(verdin, directory=str(tmp_path), segment_mb="1")
    tool = opened(node, hosts=True)
    assert (tool.kind, tool.traces, tool.limits.segment_bytes) == ("EndEffector", tmp_path, 1_000_000)
    assert node.closers == [tool.close]
    assert node.starters == [tool.start], "frames come once all nodes are there"
    (check,) = node.ticks
    check()
    assert node.failed == []
    tool.alive = False
    check()
    assert [str(each) for each in node.failed] == ["The program of the tool has failed."]


def test_without_a_folder_there_is_no_trace(verdin: Description) -> None:
    assert opened(Node(verdin), hosts=True).traces is None


@pytest.mark.parametrize(("hosts", "connect"), [(False, ""), (True, "True"), (True, "true")])
def test_every_other_process_talks_to_the_hal(verdin: Description, hosts: bool, connect: str) -> None:
    node = Node(verdin, connect=connect)
    tool = opened(node, hosts=hosts)
    assert tool.kind == "RemoteTool"
    assert node.closers == [tool.close]
    assert node.starters == [tool.start]
    assert node.ticks == [], "it waits for the HAL as long as that takes"
