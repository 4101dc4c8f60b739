"""How a node ends: a signal interrupts nothing, and what hangs is left."""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

import pytest

pytestmark = pytest.mark.ros
MADE = """
import os, signal, threading, time
from end_effector_hal.nodes import process
from end_effector_hal.ros1._ros_node import RosNode
process.LONGEST_S = 3.0
lock = threading.Lock()
def needs_the_lock():
    with lock:
        print("closed", flush=True)
def hangs_at_its_end():
    time.sleep(600)
"""
INTERRUPTED = f"""{MADE}
with RosNode("data_logger", ["interrupted", "__name:=interrupted"]) as node:
    node.on_close(needs_the_lock)
    with lock:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.2)
    print("made", flush=True)
    node.spin()
"""
HANGS = f"""{MADE}
with RosNode("data_logger", ["hangs", "__name:=hangs"]) as node:
    node.on_close(hangs_at_its_end)
    print("ready", flush=True)
    node.spin()
"""


def test_a_signal_while_a_node_is_made_closes_it_only_once_it_is_made(system: Any) -> None:
    child = system.start("interrupted", sys.executable, "-c", INTERRUPTED)
    assert child.wait_for_end(timeout_s=20.0) == 0
    assert child.text().splitlines() == ["made", "closed"]


def test_a_node_that_hangs_as_it_closes_is_left_by_force_and_says_where(system: Any) -> None:
    child = system.start("hangs", sys.executable, "-c", HANGS)
    system.until("the node", lambda: "ready" in child.text())
    os.kill(child.pid, signal.SIGINT)
    assert child.wait_for_end(timeout_s=20.0) == 1
    assert "in hangs_at_its_end" in child.text()
