"""What a simulated grip costs: a whole tool in virtual time, and its physics solved beside the same in steps.

`python -m benchmarks.simulation`; seconds are of the processor. The blocks of what is compared take turns, so that a
busy machine hits them alike.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from statistics import median
from typing import Any

from end_effector_hal.description import load, profile_path
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench import physics
from end_effector_lab.virtual import VirtualTool
from tests.unit.testbench.stepping import cylinder, device, parts, vacuum

SHIPPED = load(profile_path())
FRAME_US, GRIP_US, LONGEST_US = 20_000, 2_000_000, 60_000_000
MODELS: tuple[tuple[str, Any, Any, Any, Any], ...] = (
    ("in steps", parts, device.Plant, vacuum.VacuumCircuit, cylinder.Cylinder),
    ("solved", physics, physics.Plant, physics.VacuumCircuit, physics.Cylinder),
)


def plant_of(model: tuple[str, Any, Any, Any, Any]) -> Any:
    """The pneumatics of the shipped tool."""
    _, made_of, plant, circuit, rod = model
    supply = made_of.Supply(600.0)
    first, second, third = (made_of.Valve(delay_us) for delay_us in (22_000, 30_000, 33_000))
    return plant(supply, {"bottom": circuit(first), "cylinder": rod(second, supply), "top": circuit(third)})


def grip_physics(model: tuple[str, Any, Any, Any, Any]) -> None:
    """A grip and a release, looked at with each frame."""
    plant, at = plant_of(model), 0
    for active in (True, False):
        for name in plant.devices:
            plant.devices[name].command(active, at)
            for _ in range(GRIP_US // 3 // FRAME_US):
                at += FRAME_US
                plant.advance(at)
                sum(each.pressure_kpa for each in plant.devices.values())


def grip_tool(seed: int) -> float:
    """From the start of a tool over a grip, held for 0.5 s, to the end of the drop; seconds of its time."""
    tool = VirtualTool(SHIPPED, seed=seed)

    def until(state: EndEffectorState) -> None:
        if not tool.run_until(tool.at + LONGEST_US, lambda: tool.statuses[-1].ee == state):
            raise SystemExit(f"never {state.name}: {tool.status.reason}")

    tool.run(1.0)
    tool.command("grip")
    until(EndEffectorState.GRIPPED)
    tool.run(0.5)
    tool.command("drop")
    until(EndEffectorState.STAND_BY)
    return tool.at / 1e6


def seconds(what: Callable[[], object]) -> float:
    """Of the processor."""
    began = time.process_time()
    what()
    return time.process_time() - began


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=10)
    blocks = parser.parse_args().blocks
    grip_tool(0)  # the network is compiled once
    taken: dict[str, list[float]] = {"tool": []} | {name: [] for name, *_ in MODELS}
    for block in range(blocks):
        taken["tool"].append(seconds(lambda block=block: grip_tool(block)))
        for model in MODELS:
            taken[model[0]].append(seconds(lambda model=model: grip_physics(model)))
    middle = {name: median(each) for name, each in taken.items()}
    print(
        f"a whole tool, from its start over a grip to the end of the drop ({grip_tool(0):.2f} s of its time):"
    )
    print(f"  {middle['tool'] * 1000:.1f} ms, {1 / middle['tool']:.0f} a second and core")
    print("the physics of a grip and a release, at 50 Hz:")
    for name, *_ in MODELS:
        print(f"  {name}: {middle[name] * 1000:.2f} ms")
    print(f"  ratio: {middle['in steps'] / middle['solved']:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
