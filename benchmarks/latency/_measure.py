"""The tool in one process, or the nodes on a ROS: a floor, an application, and what is measured of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros1 import Master, start_nodes
from end_effector_lab.demo._ros2 import FIVE, ONE, PROGRAM, apart
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
    """Measure an application with a line arbiter and a testbench; logs go to ``folder``.

    Args:
        description: the tool.
        folder: of the logs.
        plan: how much.
        say: what is being done.
        part: ``core``: ``EndEffector``; ``ros``: the nodes of ROS 1; ``ros2-one``, ``ros2-five``: those of ROS 2, held
            against the floor without ROS.
    """
    notes, env = folder / "states.jsonl", None
    with Hardware(description, folder) as hardware:
        children = hardware.children
        if part == "ros":
            master = Master(folder / "ros")
            master.start(children, folder / "roscore.log", patience_s=START_S)
            env = master.env
        floor = Floor(children, hardware.place, folder, env)
        pids: dict[str, int] = {}
        if part == "ros":
            start_nodes(hardware, master.env)
            client = Driven(children, "latency/_action_client.py", [notes], folder, env)
        elif part == "core":
            client = Driven(children, "latency/_tool_client.py", [hardware.description_path, notes], folder)
            pids = {"tool": client.pid}
        else:
            env = apart(folder / "ros")
            pids = _start_ros2(hardware, ONE if part == "ros2-one" else FIVE, env)
            client = Driven(children, "latency/_action_client_ros2.py", [notes], folder, env)
        client.wait_ready()
        result = measure_blocks(hardware, floor, client, notes, plan, say)
        result.losses = measure_losses(hardware, client, Tail(notes), plan.losses, say)
        pids = pids or _nodes(children)
        result.usage = hold(client, pids | {"line arbiter": hardware.arbiter.pid}, plan.hold_s, say)
        return result


def _start_ros2(hardware: Hardware, programs: Sequence[str], env: Mapping[str, str]) -> dict[str, int]:
    arguments = ["--ros-args", "-p", f"description:={hardware.description_path.absolute()}"]
    started = {
        program: hardware.children.start(
            program, [*PROGRAM, program, *arguments], log=hardware.folder / f"{program}.log", env=env
        )
        for program in programs
    }
    return {program: child.pid for program, child in started.items()}


def _nodes(children: Children) -> dict[str, int]:
    """Process of each node; roslaunch tells each its name."""
    found = {}
    for pid in children.left():
        with suppress(OSError):
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            found |= {name: pid for name in NODES if f"__name:={name}".encode() in words}
    if missing := [name for name in NODES if name not in found]:
        raise RosError(f"The nodes {', '.join(missing)} do not run.")
    return found
