"""A bus whose port is missing, with real processes: the arbiter says so, and nothing is said of its outputs."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from end_effector_lab.processes import EEHAL
from tests.support.places import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]


def test_an_arbiter_without_the_port_is_not_ready_and_nobody_says_that_a_part_is_held(tmp_path: Path) -> None:
    text = (ROOT / "examples/tools/gripper_2f85/end_effector.yaml").read_text("utf-8")
    lines = f"{{backend: virtual, path: {tmp_path}/chip, socket: {tmp_path}/a.sock}}"
    tool = tmp_path / "tool.yaml"
    tool.write_text(
        text.replace("/dev/ttyUSB0", f"{tmp_path}/none").replace("{backend: gpiod}", lines), "utf-8"
    )
    with subprocess.Popen([*EEHAL, "arbiter", str(tool)], stdout=subprocess.PIPE, text=True) as arbiter:
        assert arbiter.stdout is not None
        said = arbiter.stdout.readline()
        run = subprocess.run(
            [*EEHAL, "run", str(tool), "--script", "status"], capture_output=True, text=True, check=False
        )
        arbiter.terminate()
    assert said.startswith("serving:")
    assert "the port does not exist" in said
    assert "whether a part is held is not known" in run.stdout
    assert "a part is held;" not in run.stdout
    assert "; a part is held" not in run.stdout
