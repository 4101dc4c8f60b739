"""A tool on wires of its own, and a line arbiter that serves it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterServer
from tests.unit.cli.doctor.parts import Machine, serving


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    for name in ("ROS_MASTER_URI", "ROS_VERSION", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    return Machine(tmp_path)


@pytest.fixture
def arbiter(machine: Machine) -> Iterator[ArbiterServer]:
    with serving(machine) as running:
        yield running
