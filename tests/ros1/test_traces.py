"""Grip and ToolChange leave their traces in the log directory, readable while they run and decided the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.tool.replay import load_trace, review, traces_of

pytestmark = pytest.mark.ros


@pytest.mark.parametrize("program", ["grip", "tool_change"])
def test_a_node_leaves_its_trace(system: Any, program: str) -> None:
    before = records(system, program)
    system.grip()
    system.run("Drop")
    system.until("records", lambda: records(system, program) > before + 5)
    trace = load_trace(path_of(system, program))
    found = review(trace)
    assert found.ok, found.as_json()
    assert not trace.file.complete
    assert found.steps > 0


def path_of(system: Any, program: str) -> Path:
    """The newest: a node that was killed begins another one."""
    paths = [path for path in traces_of(system.folder / "log") if path.name.startswith(program)]
    return max(paths, key=lambda path: path.stat().st_mtime_ns)


def records(system: Any, program: str) -> int:
    return len(load_trace(path_of(system, program)).file.records)
