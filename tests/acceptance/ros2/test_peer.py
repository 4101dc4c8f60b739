"""Another generation of the client library and of Fast DDS is understood: `make test-ros2-peer`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState
from tests.acceptance.ros2.conftest import without_wheels

CLIENT = Path(__file__).with_name("peer_client.py")
PEERS = {"this one": sys.executable, "another": os.environ.get("EEHAL_ROS2_PEER", "")}
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.mark.parametrize("peer", PEERS)
def test_a_client_of_the_tutorials_grips_cancels_and_drops(system: Any, peer: str) -> None:
    if not PEERS[peer]:
        pytest.skip("make test-ros2-peer makes the environment of another distribution")
    done = subprocess.run(
        [PEERS[peer], str(CLIENT), "TriggerGrip!", "TriggerGrip", "UnlockToolChanger", "Drop"],
        env=without_wheels() | system.env,
        capture_output=True, text=True, timeout=150, check=False,
    )  # fmt: skip
    said = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    assert [each["status"] for each in said] == [CANCELED, SUCCEEDED, ABORTED, SUCCEEDED], (
        done.stdout + done.stderr
    )
    cancelled, gripped, refused, dropped = said
    assert cancelled["outcome"] == "CANCELLED"
    assert (gripped["outcome"], "GRIPPING" in gripped["feedback"]) == ("SUCCEEDED", True)
    assert refused["outcome"] == "REJECTED"
    assert refused["reason"]
    assert dropped["outcome"] == "SUCCEEDED"
    system.wait_for(EndEffectorState.STAND_BY)
