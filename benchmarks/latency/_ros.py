"""Through ROS: a master of its own, the shipped launch file, an application with an action client."""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._children import Children
from end_effector_lab.demo._master import Master

from ._blocks import Tail, hold, measure
from ._driven import Driven
from ._floor import Floor
from ._hardware import Hardware
from ._losses import measure_losses
from ._plan import Plan
from ._result import Result

NODES = ("HALMain", "Grip", "ToolChange", "Pressure", "Position")
START_S, END_S = 40.0, 20.0


def measure_ros(description: Description, folder: Path, plan: Plan, say: Callable[[str], None]) -> Result:
    """Measure the five nodes with a line arbiter and a testbench; logs go to ``folder``."""
    notes = folder / "states.jsonl"
    with Hardware(description, folder) as hardware:
        ros = Master(folder / "ros")
        ros.start(hardware.children, folder / "roscore.log", patience_s=START_S)
        env = ros.env
        floor = Floor(hardware.children, hardware.place, folder, env)
        hardware.children.start(
            "launch file",
            ["roslaunch", "--wait", "end_effector_hal", "end_effector.launch", "owner:=false",
             f"description:={hardware.description_path.absolute()}"],
            log=folder / "roslaunch.log", failed=RosError, env=env, end_by=signal.SIGINT, patience_s=END_S,
        )  # fmt: skip
        client = Driven(hardware.children, "latency/_action_client.py", [notes], folder, env)
        client.wait_ready()
        result = measure(hardware, floor, client, notes, plan, say)
        result.losses = measure_losses(hardware, client, Tail(notes), plan.losses, say)
        pids = _pids(hardware.children) | {"line arbiter": hardware.owner.pid}
        result.usage = hold(client, pids, plan.hold_s, say)
        return result


def _pids(children: Children) -> dict[str, int]:
    """Of the five nodes; roslaunch tells each its name."""
    found = {}
    for pid in children.left():
        with suppress(OSError):
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            found |= {name: pid for name in NODES if f"__name:={name}".encode() in words}
    if missing := [name for name in NODES if name not in found]:
        raise RosError(f"The nodes {', '.join(missing)} do not run.")
    return found
