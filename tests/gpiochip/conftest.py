"""Runs only where it was asked for (`make test-gpiochip`): a kernel must be built, and it takes minutes."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load, profile_path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    asked = "EEHAL_GPIOCHIP" in os.environ
    for item in items:
        if item.path.parent == HERE:
            item.add_marker(pytest.mark.wall)
            item.add_marker(pytest.mark.timeout(600))
            if not asked:
                item.add_marker(pytest.mark.skip(reason="make test-gpiochip: it boots a kernel of its own"))


@pytest.fixture(scope="session")
def kernel() -> Path:
    """The User-Mode-Linux kernel; built when there is none."""
    built = subprocess.run([HERE / "build-kernel.sh"], capture_output=True, text=True, check=False)
    if built.returncode:
        pytest.skip(built.stderr.strip().splitlines()[-1])
    return Path(built.stdout.strip())


@pytest.fixture(scope="session")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Description:
    """The shipped tool with the port that the guest has."""
    text = profile_path().read_text()
    path = tmp_path_factory.mktemp("tool") / "end_effector.yaml"
    path.write_text(text.replace("port: /dev/verdin-uart1", "port: /dev/ttyS0"))
    description = load(path)
    assert description.link.port == "/dev/ttyS0"
    return description


@pytest.fixture
def place() -> Iterator[Path]:
    """For sockets and the like: their paths may be 108 bytes long only."""
    with tempfile.TemporaryDirectory(prefix="eehal-uml-") as name:
        yield Path(name)


@pytest.fixture(scope="session")
def runs() -> Path:
    """Where the recordings stay."""
    return ROOT / "runs" / "gpiochip"
