"""Without ROS: the tool in one process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from end_effector_hal.description import Description

from ._blocks import Tail, hold, measure
from ._driven import Driven
from ._floor import Floor
from ._hardware import Hardware
from ._losses import measure_losses
from ._plan import Plan
from ._result import Result


def measure_core(description: Description, folder: Path, plan: Plan, say: Callable[[str], None]) -> Result:
    """Measure ``EndEffector`` with a line arbiter and a testbench; logs go to ``folder``."""
    notes = folder / "states.jsonl"
    with Hardware(description, folder) as hardware:
        floor = Floor(hardware.children, hardware.place, folder)
        client = Driven(
            hardware.children, "latency/_tool_client.py", [hardware.description_path, notes], folder
        )
        client.wait_ready()
        result = measure(hardware, floor, client, notes, plan, say)
        result.losses = measure_losses(hardware, client, Tail(notes), plan.losses, say)
        pids = {"tool": client.pid, "line arbiter": hardware.owner.pid}
        result.usage = hold(client, pids, plan.hold_s, say)
        return result
