"""What needs the board runs only where it was asked for (`make test-board`): it is emulated, and takes minutes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.support.by_hand import only_when_asked
from tests.support.places import ROOT
from tools.board import board_parts

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    asked, reason = "EEHAL_BOARD" in os.environ, "make test-board: it emulates a whole board"
    only_when_asked(items, HERE, {"parts"}, asked=asked, timeout_s=3600, reason=reason)


@pytest.fixture(scope="session")
def parts() -> Path:
    """QEMU, kernel, device tree, root; built when they are not there."""
    return board_parts()


@pytest.fixture(scope="session")
def runs() -> Path:
    """Where the recordings of all tests stay."""
    return ROOT / "runs"
