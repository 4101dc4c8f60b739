"""Measurement of the tool in one process, or of the nodes on a ROS: floor, application, and results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from environments import Environment, environment

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros import FIVE, ONE, PROGRAM, Master, apart, start_nodes
from end_effector_lab.processes import Children

from ._blocks import Plan, Tail, hold, measure_blocks
from ._driven import Driven
from ._floor import Floor
from ._hardware import Hardware
from ._losses import measure_losses
from ._result import Result

NODES = ("HALMain", "Grip", "ToolChange", "Pressure", "Position")
START_S = 40.0


def measure(
    description: Description, folder: Path, plan: Plan, say: Callable[[str], None], part: str
) -> Result:
    """Measure an application with a new line arbiter and testbench; logs go to ``folder``.

    Args:
        description: the tool.
        folder: folder for the logs.
        plan: the counts.
        say: reports progress.
        part: ``core``: ``EndEffector``; ``ros``: the nodes of ROS 1; ``ros2-one``, ``ros2-five``: those of ROS 2.
    """
    notes, where = folder / "states.jsonl", environment(part)
    with Hardware(description, folder) as hardware:
        children = hardware.children
        if part == "ros":
            master = Master(folder / "ros")
            # the workspace is in its path
            master.env = {**where.env, **master.env, "PATH": where.env["PATH"]}
            where = where.with_env(master.env)
            master.start(children, folder / "roscore.log", patience_s=START_S)
        elif part != "core":
            where = where.with_env(apart(folder / "ros"))
        floor = Floor(children, hardware.place, folder, where, part)
        pids: dict[str, int] = {}
        if part == "ros":
            start_nodes(hardware, where.env)
            client = Driven(children, "latency/_action_client.py", [notes], folder, where)
        elif part == "core":
            client = Driven(children, "latency/_tool_client.py", [hardware.description_path, notes], folder)
            pids = {"tool": client.pid}
        else:
            pids = _start_ros2(hardware, ONE if part == "ros2-one" else FIVE, where)
            client = Driven(children, "latency/_action_client_ros2.py", [notes], folder, where)
        client.wait_ready()
        result = measure_blocks(hardware, floor, client, notes, plan, say)
        result.losses = measure_losses(hardware, client, Tail(notes), plan.losses, say)
        pids = pids or _nodes(children)
        result.usage = hold(client, pids | {"line arbiter": hardware.arbiter.pid}, plan.hold_s, say)
        return result


def _start_ros2(hardware: Hardware, programs: Sequence[str], where: Environment) -> dict[str, int]:
    arguments = ["--ros-args", "-p", f"description:={hardware.description_path.absolute()}"]
    started = {
        program: hardware.children.start(
            program,
            [where.python, *PROGRAM[1:], program, *arguments],
            log=hardware.folder / f"{program}.log",
            env=where.env,
        )
        for program in programs
    }
    return {program: child.pid for program, child in started.items()}


def _nodes(children: Children) -> dict[str, int]:
    """Return the process id of each node, found by the name that roslaunch passes."""
    found = {}
    for pid in children.left():
        with suppress(OSError):
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            found |= {name: pid for name in NODES if f"__name:={name}".encode() in words}
    if missing := [name for name in NODES if name not in found]:
        raise RosError(f"The nodes {', '.join(missing)} do not run.")
    return found
