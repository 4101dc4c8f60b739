"""Runs only where it was asked for (`make test-image`): it needs the image that `make image` builds."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from end_effector_lab.processes import EEHAL, Children
from tests.acceptance.image.box import Box, buildah

HERE = Path(__file__).parent
ASKED = os.environ.get("EEHAL_IMAGE", "")
MACHINE = {"x86_64": "amd64", "aarch64": "arm64"}.get(os.uname().machine)
GPIO, DIALOUT = 49, 20
NATIVE_S, EMULATED_S = 120.0, 900.0
"""The longest that one command may take; qemu-user is slow, and slower on a busy machine."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.parent == HERE:
            item.add_marker(pytest.mark.wall)
            item.add_marker(pytest.mark.timeout(2 * EMULATED_S))
            if not ASKED:
                item.add_marker(pytest.mark.skip(reason="make test-image: it needs the container image"))


@dataclass(frozen=True)
class Image:
    """Which one; ``emulated``: its programs are of another architecture than this machine's."""

    name: str
    emulated: bool

    @property
    def ros2(self) -> bool:
        return "-ros2:" in self.name

    @property
    def limit_s(self) -> float:
        return EMULATED_S if self.emulated else NATIVE_S


@pytest.fixture(scope="session")
def image() -> Image:
    if not shutil.which("buildah"):
        pytest.fail("buildah is missing; on Debian 12: apt install buildah")
    architecture = buildah("inspect", "--type=image", "--format={{.OCIv1.Architecture}}", ASKED)
    return Image(ASKED, emulated=architecture != MACHINE)


def belongs_to(path: Path, group: int) -> None:
    """As on a board: root's, and of a group; where this user may not say so, everybody's."""
    try:
        os.chown(path, -1, group)
        path.chmod(0o2770 if path.is_dir() else 0o660)
    except PermissionError:
        path.chmod(0o777 if path.is_dir() else 0o666)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The other end of the wires, outside of the container: lines of the group gpio, a port of the group dialout."""
    folder = tmp_path_factory.mktemp("image") / "bench"
    folder.mkdir()
    # pytest's folders are for their owner only, and a container's user is another
    for above in folder.parents:
        with suppress(PermissionError):
            above.chmod(above.stat().st_mode | 0o055)
        if above.name.startswith("pytest-of-"):
            break
    belongs_to(folder, GPIO)
    chip, uart = folder / "chip", folder / "uart"
    with Children() as children:
        testbench = children.start(
            "testbench",
            [*EEHAL, "testbench", "--lines", f"virtual:{chip}", "--port", f"pty:{uart}"],
            log=folder.parent / "testbench.log",
            commands=True,
        )
        testbench.wait_until(lambda: "ready:" in testbench.text(), timeout_s=60, what="it was ready")
        belongs_to(chip, GPIO)
        chip.with_name("chip.lock").unlink(missing_ok=True)
        belongs_to(uart.resolve(), DIALOUT)
        yield folder


@pytest.fixture(scope="module")
def box(image: Image, bench: Path) -> Iterator[Box]:
    """A container whose tool is the shipped one, on the wires of the bench."""
    text = profile_path().read_text()
    wires = {
        "backend: gpiod": "backend: virtual\n  path: /bench/chip",
        # on a busy machine, and the more so when emulated, a frame may come late without meaning anything
        "port: /dev/verdin-uart1": "port: /bench/uart\n  stale_s: 2.0\n  down_s: 10.0",
    }
    for shipped, here in wires.items():
        assert shipped in text
        text = text.replace(shipped, here)
    tool = bench / "end_effector.yaml"
    tool.write_text(text)
    tool.chmod(0o644)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    env = {"EEHAL_DESCRIPTION": "/bench/end_effector.yaml", "ROS_MASTER_URI": f"http://127.0.0.1:{port}"}
    box = Box(image.name, bench, env, limit_s=image.limit_s)
    try:
        yield box
    finally:
        box.end()
