"""Three cells of the matrix, with every process for real; `make kill-matrix` plays the others."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.places import ROOT

ROS = shutil.which("roscore") and all(
    importlib.util.find_spec(name) for name in ("rospy", "end_effector_msgs")
)
CELLS = ("Grip:SIGSTOP:GRIPPING top_vacuum", "LineOwner:SIGKILL:GRIPPED", "Grip:SIGKILL:GRIPPED")

pytestmark = [
    pytest.mark.ros,
    pytest.mark.alone,
    pytest.mark.timeout(200),
    pytest.mark.skipif(not ROS, reason="no ROS here, or its workspace is not sourced"),
]


def test_some_cells(tmp_path: Path) -> None:
    kept = tmp_path / "matrix.json"
    run = subprocess.run(
        [sys.executable, "-m", "tests.acceptance.kill_matrix.run", "--systems", "1", "-o", str(kept), *CELLS],
        cwd=ROOT, capture_output=True, text=True, timeout=180, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    rows = json.loads(kept.read_text())
    assert {f"{row['process']}:{row['signal']}:{row['state']}" for row in rows} == set(CELLS)
    assert all(row["ok"] for row in rows)
    assert [row["observed"] for row in rows if row["state"] == "GRIPPED"] == ["GRIPPED; no line moves"] * 2
