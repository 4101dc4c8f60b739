"""Runs only where it was asked for (`make test-board`): it needs QEMU 10 and takes minutes."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "gpiochip")]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    asked = "EEHAL_BOARD" in os.environ
    for item in items:
        if item.path.parent == HERE:
            item.add_marker(pytest.mark.wall)
            item.add_marker(pytest.mark.timeout(900))
            if not asked:
                item.add_marker(pytest.mark.skip(reason="make test-board: it emulates a whole board"))


@pytest.fixture(scope="session")
def parts() -> Path:
    """QEMU, kernel, device tree, root; built when they are not there."""
    built = subprocess.run([HERE / "build-board.sh"], capture_output=True, text=True, check=False)
    if built.returncode:
        pytest.skip(built.stderr.strip().splitlines()[-1])
    return Path(built.stdout.strip())


@pytest.fixture
def place() -> Iterator[Path]:
    """For sockets: their paths may be 108 bytes long only."""
    with tempfile.TemporaryDirectory(prefix="eehal-board-") as name:
        yield Path(name)
