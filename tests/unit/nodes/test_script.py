"""The programs of the ROS package before a node is up: `ros2 launch` and the terminal may end them at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.places import ROOT

SCRIPT = ROOT / "ros" / "end_effector_hal" / "scripts" / "hal"
IMPORTED = """
import time
print("importing", flush=True)
try:
    time.sleep(60)
except BaseException:  # as a callback within an import does
    time.sleep(60)
"""


@pytest.mark.parametrize("generation", [1, 2])
def test_ctrl_c_amid_imports_ends_it_without_a_word(tmp_path: Path, generation: int) -> None:
    package = tmp_path / "end_effector_hal"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / f"ros{generation}.py").write_text(IMPORTED)
    env = {**os.environ, "PYTHONPATH": str(tmp_path), "ROS_VERSION": str(generation)}
    with subprocess.Popen(
        [sys.executable, SCRIPT], env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout
        assert program.stdout.readline() == "importing\n"
        program.send_signal(signal.SIGINT)
        said = program.communicate(timeout=30)
    assert (program.returncode, said) == (-signal.SIGINT, ("", ""))
