"""What needs the board runs only where it was asked for (`make test-board`): it is emulated, and takes minutes."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from end_effector_hal.board import board_parts

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "gpiochip"))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    asked = "EEHAL_BOARD" in os.environ
    for item in items:
        if item.path.parent == HERE and "parts" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.wall)
            item.add_marker(pytest.mark.timeout(3600))
            if not asked:
                item.add_marker(pytest.mark.skip(reason="make test-board: it emulates a whole board"))


@pytest.fixture(scope="session")
def parts() -> Path:
    """QEMU, kernel, device tree, root; built when they are not there."""
    return board_parts()


@pytest.fixture(scope="session")
def runs() -> Path:
    """Where the recordings of all tests stay."""
    return HERE.parents[1] / "runs"
