"""How a node ends when what it has to do at its end hangs."""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

import pytest

pytestmark = pytest.mark.ros
HANGS = """
import time
from end_effector_hal.nodes.process import _process_end
from end_effector_hal.ros1._ros_node import RosNode
_process_end.LONGEST_S = 1.0
def hangs_at_its_end():
    time.sleep(600)
with RosNode("data_logger", ["hangs", "__name:=hangs"]) as node:
    node.on_close(hangs_at_its_end)
    print("ready", flush=True)
    node.spin()
"""


def test_a_node_that_hangs_as_it_closes_is_left_by_force_and_says_where(system: Any) -> None:
    child = system.start("hangs", sys.executable, "-c", HANGS)
    system.until("the node", lambda: "ready" in child.text())
    os.kill(child.pid, signal.SIGINT)
    assert child.wait_for_end(timeout_s=20.0) == 1
    assert "in hangs_at_its_end" in child.text()
