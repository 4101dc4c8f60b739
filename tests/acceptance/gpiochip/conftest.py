"""Runs only where it was asked for (`make test-gpiochip`): a kernel must be built, and it takes minutes.

``EEHAL_GPIOCHIP=gpio-sim`` (root): on the chips that this machine's own kernel simulates.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load, profile_path
from tests.acceptance.gpiochip.machines import Guest, Machine, ThisMachine, lacks_gpio_sim
from tests.acceptance.gpiochip.priority import MEMORY
from tests.acceptance.gpiochip.slow_link import with_a_slow_link
from tests.acceptance.gpiochip.virtual_lines import OnVirtualLines
from tests.support.by_hand import only_when_asked
from tests.support.places import ROOT

HERE = Path(__file__).parent
ASKED = os.environ.get("EEHAL_GPIOCHIP", "")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    reason = "make test-gpiochip: it boots a kernel of its own"
    only_when_asked(items, HERE, {"kernel", "machine"}, asked=bool(ASKED), timeout_s=900, reason=reason)


@pytest.fixture(scope="session")
def kernel() -> Iterator[Path]:
    """The User-Mode-Linux kernel; built when there is none. Nobody removes it meanwhile (`forget-others.sh`)."""
    if ASKED == "gpio-sim":
        pytest.skip("EEHAL_GPIOCHIP=gpio-sim: no guest is booted.")
    if missing := [name for name in ("busybox", "taskset") if shutil.which(name) is None]:
        packages = (HERE / "debian-packages.txt").read_text().split()
        pytest.skip(f"Missing: {', '.join(missing)}; apt install {' '.join(packages)}")
    built = subprocess.run([HERE / "build-kernel.sh"], capture_output=True, text=True, check=False)
    if built.returncode == 3:
        pytest.skip(built.stderr.strip().splitlines()[-1])
    assert built.returncode == 0, built.stderr
    path = Path(built.stdout.strip())
    with path.open("rb") as used:
        fcntl.flock(used, fcntl.LOCK_SH)
        yield path


@pytest.fixture(scope="session")
def machine(request: pytest.FixtureRequest) -> Machine:
    """Where the HAL runs."""
    if ASKED != "gpio-sim":
        return Guest(request.getfixturevalue("kernel"))
    if missing := lacks_gpio_sim():
        pytest.skip(missing)
    return ThisMachine()


@pytest.fixture(scope="session")
def tool() -> Description:
    """The shipped tool."""
    return load(profile_path())


@pytest.fixture(scope="session")
def on_virtual_lines(tool: Description, runs: Path) -> dict[bool, OnVirtualLines]:
    """The same scenarios on virtual lines; ``True``: of the tool that is played through ROS, whose link is slower."""
    slow = with_a_slow_link(tool, runs / "slow_link.yaml")
    return {False: OnVirtualLines(tool, runs / "virtual"), True: OnVirtualLines(slow, runs / "virtual-slow")}


@pytest.fixture
def place() -> Iterator[Path]:
    """For sockets and the like: their paths may be 108 bytes long only."""
    with tempfile.TemporaryDirectory(prefix="eehal-uml-", dir=MEMORY) as name:
        yield Path(name)


@pytest.fixture(scope="session")
def runs() -> Path:
    """Where the recordings stay."""
    return ROOT / "runs" / "gpiochip"
