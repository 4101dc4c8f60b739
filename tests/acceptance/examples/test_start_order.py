"""Every example and every codec on virtual wires, started word for word as docs/how-to/simulate.md says."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.codecs import codec_names, get_codec, load_tool
from end_effector_hal.description import profile_path
from end_effector_hal.errors import NotReadyError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.signals import Kind
from end_effector_lab.processes import EEHAL
from tests.support.command import eehal
from tests.support.nightly import first_of
from tests.support.patience import wait_until

from .conftest import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.alone, pytest.mark.timeout(300)]
TOOLS = {each.parent.name: each for each in sorted((ROOT / "examples/tools").glob("*/end_effector.yaml"))}
CODECS = [each for each in codec_names() if each not in ("gauge", "jaw-line")]
ONES = ("double_acting_jaw", "gripper_2f85", "modbus-rtu-onrobot-vg")
"""An e-stop that is active low, no line of a board at all, a parity."""
NAMES = (*ONES, *(each for each in (*TOOLS, *CODECS) if each not in ONES))


@contextmanager
def background(log: Path, *words: object) -> Iterator[Path]:
    """A program behind an `&`: nobody waits until it is ready."""
    with log.open("wb") as output:
        process = subprocess.Popen(
            [*EEHAL, *map(str, words)], stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT
        )
    try:
        yield log
        assert process.poll() is None, log.read_text("utf-8")
    finally:
        if process.poll() is None:
            os.kill(process.pid, signal.SIGTERM)
        process.wait(30)


def described(name: str, folder: Path) -> Path:
    """An example, or a cup whose link has a codec."""
    if name in TOOLS:
        return TOOLS[name]
    pressures = [each for each, kind in get_codec(name).channels.items() if kind is Kind.PRESSURE]
    path = folder / "cup.yaml"
    path.write_text(
        f"name: cup\nlink: {{port: /dev/ttyS0, codec: {name}}}\nsequence: [cup]\nsupply: {{channel: none}}\n"
        f"actuators: {{cup: {{kind: vacuum, line: A, channel: {(pressures or ['bottom'])[0]}}}}}\n"
    )
    return path


@contextmanager
def started(tool: Path, folder: Path, *more: str) -> Iterator[Path]:
    copy = Path(eehal("testbench", "--prepare", folder, tool).strip())
    with (
        background(folder / "testbench.log", "testbench", copy, *more) as bench,
        background(folder / "arbiter.log", "arbiter", copy) as arbiter,
    ):
        wait_until("the testbench is ready", lambda: "ready:" in bench.read_text("utf-8"))
        wait_until("the arbiter is ready", lambda: "ready:" in arbiter.read_text("utf-8"))
        yield copy


@pytest.mark.parametrize("name", first_of(NAMES, 1, 2))
def test_a_simulated_tool_starts_and_grips_twice(name: str, tmp_path: Path) -> None:
    with started(described(name, tmp_path), tmp_path / "wires") as copy:
        eehal("doctor", copy, "--only", "description,lines,arbiter,link,inputs")
        changer = load_tool(copy).tool_changer is not None
        for _ in range(2):
            said = eehal("run", copy, "--script", "lock; grip; drop" if changer else "grip; drop")
            assert "say hello" not in said


def test_an_e_stop_that_was_opened_is_named_before_the_first_grip(tmp_path: Path) -> None:
    tool = TOOLS["double_acting_jaw"]
    why = "double_acting_jaw is not ready: latched: IL-13: the emergency stop was opened."
    with started(tool, tmp_path / "wires", "--scenario", "estop-open") as copy:
        with EndEffector.open(copy) as opened, pytest.raises(NotReadyError) as refused:
            opened.wait_ready(60.0)
        assert str(refused.value).startswith(why)
        command = [*EEHAL, "run", str(copy), "--script", "status"]
        assert why in subprocess.run(command, capture_output=True, text=True, check=False).stderr


@pytest.mark.thinned
def test_the_shipped_tool_starts_in_either_order(tmp_path: Path) -> None:
    copy = Path(eehal("testbench", "--prepare", tmp_path, profile_path()).strip())
    with background(tmp_path / "arbiter.log", "arbiter", copy) as arbiter:
        wait_until("the arbiter is ready", lambda: "ready:" in arbiter.read_text("utf-8"))
        with background(tmp_path / "testbench.log", "testbench", copy) as bench:
            wait_until("the testbench is ready", lambda: "ready:" in bench.read_text("utf-8"))
            eehal("run", copy, "--script", "lock; grip; drop")
