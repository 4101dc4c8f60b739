"""A simulated world, and ``eehal run`` in it at a terminal of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.terminal import Terminal


@pytest.fixture
def terminal(world: World, tmp_path: Path) -> Iterator[Terminal]:
    """At the world of the test, once it is in STAND_BY."""
    home = {"XDG_STATE_HOME": str(tmp_path / "state")}
    with Terminal([*EEHAL, "run", str(world.description_path)], env=home) as running:
        running.read_until("OFF -> STAND_BY")
        yield running
