"""A node that is killed while it reads its shared memory does not stop the tool, whose node publishes to it."""

from __future__ import annotations

import mmap
import os
import signal
import struct
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import IO

from end_effector_hal.description import load, profile_path
from end_effector_hal.ros2 import without_shared_memory
from end_effector_lab.demo._ros import ONE
from end_effector_lab.demo._world import World
from tests.acceptance.ros2.conftest import System, without_wheels

READER = """
import time, rclpy
from end_effector_msgs.msg import EndEffectorState
rclpy.init()
node = rclpy.create_node("reader")
node.create_subscription(EndEffectorState, "EndEffectorState", lambda _: print(time.monotonic(), flush=True), 10)
rclpy.spin(node)
"""
PROCESS_SHARED = (128, 129)
"""Kinds of a mutex of glibc in shared memory that is not robust: normal, recursive."""
SILENCE_S = 0.9
"""Fast DDS waits for such a mutex for a second, several times, or for ever."""


@contextmanager
def reader(env: Mapping[str, str]) -> Iterator[subprocess.Popen[str]]:
    """A node that prints the time of each message."""
    with subprocess.Popen(
        [sys.executable, "-c", READER], env=env, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process
        process.kill()


def times(output: IO[str] | None, seconds: float) -> list[float]:
    """When messages came, for some seconds."""
    assert output is not None
    found = [float(output.readline())]
    while found[-1] < found[0] + seconds:
        found.append(float(output.readline()))
    return found


def ports_of(pid: int) -> set[str]:
    """The ports in shared memory that a process has opened."""
    mapped = Path(f"/proc/{pid}/maps").read_text(encoding="utf-8").split()
    return {word for word in mapped if word.startswith("/dev/shm/fastrtps_port")}


def die_reading(process: subprocess.Popen[str], others: set[str]) -> int:
    """Kill a process while it holds the mutexes of its own ports; the number of mutexes."""
    os.kill(process.pid, signal.SIGSTOP)
    held = 0
    for path in ports_of(process.pid) - others:
        with open(path, "r+b") as file, mmap.mmap(file.fileno(), 0) as port:
            for offset in range(0, len(port) - 20, 8):
                lock, count, _, _, kind = struct.unpack_from("<iIiIi", port, offset)
                if count == 0 and kind in PROCESS_SHARED and lock in (0, 1, 2):
                    struct.pack_into("<iIiI", port, offset, 2, 0, process.pid, 1)
                    held += 1
    process.kill()
    return held


def test_the_tool_goes_on_when_a_node_dies_with_a_mutex(tmp_path: Path) -> None:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        system = System(world, tmp_path, ONE)
        system.start_nodes()
        as_always = {**without_wheels(), **system.env}
        unharmed = dict(as_always)
        without_shared_memory(unharmed)
        with reader(unharmed) as other:
            times(other.stdout, 1)
            of_the_tool = ports_of(system.nodes["hal"].pid)
            with reader(as_always) as victim:
                times(victim.stdout, 1)
                assert die_reading(victim, of_the_tool) > 0
                heard = times(other.stdout, 6)
    assert max(after - before for before, after in pairwise(heard)) < SILENCE_S
