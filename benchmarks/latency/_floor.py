"""The floor's processes, with ROS or without, and their notes."""

from __future__ import annotations

import time
from pathlib import Path

from environments import Environment

from end_effector_lab.processes import Children

from ._driven import BENCHMARKS, Driven

HALF_PERIOD_US = 10_000


class Floor:
    """The chain of the floor's processes, ready to run.

    Args:
        children: starts its processes, and ends them.
        place: folder for pty, socket and file.
        folder: receives logs and notes.
        where: its interpreter and environment.
        part: the part of the benchmark whose floor it is.
    """

    def __init__(self, children: Children, place: Path, folder: Path, where: Environment, part: str) -> None:
        port, socket, lines = place / "floor-uart", place / "floor.sock", place / "floor-lines"
        self.notes = (folder / "floor-edges.jsonl", folder / "floor-states.jsonl")
        self._bench = Driven(children, "floor/testbench.py", [port, lines, self.notes[0]], folder)
        self._bench.wait_ready()
        start = children.start
        floor = BENCHMARKS / "floor"

        def process(name: str, *arguments: object) -> int:
            command = [where.python, str(floor / f"{name}.py"), *map(str, arguments)]
            return start(f"floor/{name}.py", command, log=folder / f"floor-{name}.log", env=where.env).pid

        self.arbiter = process("arbiter", socket, lines)
        self.nodes: dict[str, int] = {}
        if part == "core":
            self._client = Driven(children, "floor/tool.py", [port, socket, self.notes[1]], folder, where)
            self.nodes["tool"] = self._client.pid
        else:
            of = "ros1" if part == "ros" else "ros2"
            self.nodes["tool"] = process(f"{of}_tool", port, socket)
            self._client = Driven(children, f"floor/{of}_client.py", [self.notes[1]], folder, where)
        self._client.wait_ready()
        time.sleep(1.0)  # for every connection

    def run(self, seconds: float, phase_us: int) -> None:
        """Run one block; its frames are midway between those of the testbench."""
        self._bench.tell(f"run {seconds} {phase_us + HALF_PERIOD_US}")
        self._client.tell(f"run {seconds}")
        for program in (self._bench, self._client):
            program.wait_done(expected_s=0.0, timeout_s=seconds + 10.0)
