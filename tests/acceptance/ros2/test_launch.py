"""What `colcon test` runs on a machine with ROS 2, run here: `ros2_launch.py` stands in for `ros2`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from end_effector_lab.demo._ros import apart
from tests.support.places import ROOT

PACKAGE = ROOT / "ros" / "end_effector_hal"
LONGEST_S = 240.0


@pytest.fixture(scope="module")
def env(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """As after `. install/setup.bash`."""
    folder = tmp_path_factory.mktemp("launch")
    ros2 = folder / "ros2"
    ros2.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" "{Path(__file__).with_name("ros2_launch.py")}" "$@"\n'
    )
    ros2.chmod(0o755)
    path = f"{folder}:{Path(sys.executable).parent}:{os.environ['PATH']}"
    prefix = f"{installed}:{sys.prefix}"
    return {
        **os.environ,
        **apart(folder / "log"),
        "ROS_VERSION": "2",
        "AMENT_PREFIX_PATH": prefix,
        "PATH": path,
    }


def _names() -> list[str]:
    """Of the tests of the package."""
    text = (PACKAGE / "test" / "test_launch.py").read_text(encoding="utf-8")
    return [line[4:].partition("(")[0] for line in text.splitlines() if line.startswith("def test_")]


@pytest.mark.timeout(LONGEST_S + 60)
@pytest.mark.parametrize("name", _names())
def test_of_the_package(env: dict[str, str], tmp_path: Path, name: str) -> None:
    command = [
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        f"--rootdir={PACKAGE}",
        f"--basetemp={tmp_path / 'of'}",
    ]
    with subprocess.Popen(
        [sys.executable, *command, f"{PACKAGE / 'test' / 'test_launch.py'}::{name}"],
        env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    ) as tests:  # fmt: skip
        try:
            said, _ = tests.communicate(timeout=LONGEST_S)
        except BaseException:
            tests.send_signal(signal.SIGINT)  # killed, it would leave what it has launched
            raise
    assert tests.returncode == 0, said
