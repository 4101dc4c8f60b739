"""The tool in one process, or the five nodes on ROS: a floor, an application, and what is measured of them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros1 import Master, start_nodes
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
    description: Description, folder: Path, plan: Plan, say: Callable[[str], None], *, ros: bool
) -> Result:
    """Measure ``EndEffector``, or the nodes, with a line arbiter and a testbench; logs go to ``folder``."""
    notes, env = folder / "states.jsonl", None
    with Hardware(description, folder) as hardware:
        children = hardware.children
        if ros:
            master = Master(folder / "ros")
            master.start(children, folder / "roscore.log", patience_s=START_S)
            env = master.env
        floor = Floor(children, hardware.place, folder, env)
        if env:
            start_nodes(hardware, env)
            client = Driven(children, "latency/_action_client.py", [notes], folder, env)
        else:
            description_path = hardware.description_path
            client = Driven(children, "latency/_tool_client.py", [description_path, notes], folder)
        client.wait_ready()
        result = measure_blocks(hardware, floor, client, notes, plan, say)
        result.losses = measure_losses(hardware, client, Tail(notes), plan.losses, say)
        pids = _nodes(children) if ros else {"tool": client.pid}
        result.usage = hold(client, pids | {"line arbiter": hardware.arbiter.pid}, plan.hold_s, say)
        return result


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
