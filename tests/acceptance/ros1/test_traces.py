"""Grip and ToolChange leave their traces in the log directory, readable while they run and decided the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.verification.replay import load_trace, review, traces_of

pytestmark = [pytest.mark.ros, pytest.mark.timeout(300)]  # all that was recorded so far is decided once more


@pytest.mark.parametrize("program", ["grip", "tool_change"])
def test_a_node_leaves_its_trace(system: Any, program: str) -> None:
    before = records(system, program)
    system.grip()
    system.run("Drop")
    system.until("records", lambda: records(system, program) > before + 5)
    steps, end = 0, None
    for path in paths_of(system, program):  # a full disk, in another test, has interrupted them
        found = review(load_trace(path), before=end)
        assert found.ok, found.as_json()
        steps, end = steps + found.steps, found.end
    assert end is not None
    assert not end.complete
    assert steps > 0


def paths_of(system: Any, program: str) -> list[Path]:
    return [path for path in traces_of(system.folder / "log") if path.name.startswith(program)]


def path_of(system: Any, program: str) -> Path:
    """The newest: a node that was killed begins another one."""
    return max(paths_of(system, program), key=lambda path: path.stat().st_mtime_ns)


def records(system: Any, program: str) -> int:
    return len(load_trace(path_of(system, program)).file.records)
