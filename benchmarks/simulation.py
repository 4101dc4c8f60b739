"""The cost of a simulated grip: a whole tool in virtual time, and its physics, compared with a fixed-step solution.

`python -m benchmarks.simulation`; seconds are processor time. The compared blocks alternate, so that other load
affects them alike.
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
HOLDS_S = 0.5, 10.0
FRAME_US, GRIP_US, LONGEST_US = 20_000, 2_000_000, 60_000_000
MODELS: tuple[tuple[str, Any, Any, Any, Any], ...] = (
    ("in steps", parts, device.Plant, vacuum.VacuumCircuit, cylinder.Cylinder),
    ("solved", physics, physics.Plant, physics.VacuumCircuit, physics.Cylinder),
)


def plant_of(model: tuple[str, Any, Any, Any, Any]) -> Any:
    """Return the pneumatics of the shipped tool."""
    _, made_of, plant, circuit, rod = model
    supply = made_of.Supply(600.0)
    first, second, third = (made_of.Valve(delay_us) for delay_us in (22_000, 30_000, 33_000))
    return plant(supply, {"bottom": circuit(first), "cylinder": rod(second, supply), "top": circuit(third)})


def grip_physics(model: tuple[str, Any, Any, Any, Any]) -> None:
    """Simulate a grip and a release, with the pressures read at each frame."""
    plant, at = plant_of(model), 0
    for active in (True, False):
        for name in plant.devices:
            plant.devices[name].command(active, at)
            for _ in range(GRIP_US // 3 // FRAME_US):
                at += FRAME_US
                plant.advance(at)
                sum(each.pressure_kpa for each in plant.devices.values())


def grip_tool(seed: int, hold_s: float = 0.5, *, each: bool = False) -> float:
    """Run a tool from its start over a grip and a hold to the end of the drop; return seconds of its time.

    Args:
        seed: seed of the tool.
        hold_s: how long the part is held.
        each: whether to play each frame, including those that change nothing.
    """
    tool = VirtualTool(SHIPPED, seed=seed, on_frame=(lambda _: None) if each else None)

    def until(state: EndEffectorState) -> None:
        if not tool.run_until(tool.at + LONGEST_US, lambda: tool.statuses[-1].ee == state):
            raise SystemExit(f"never {state.name}: {tool.status.reason}")

    tool.run(1.0)
    tool.command("grip")
    until(EndEffectorState.GRIPPED)
    tool.run(hold_s)
    tool.command("drop")
    until(EndEffectorState.STAND_BY)
    return tool.at / 1e6


def seconds(what: Callable[[], object]) -> float:
    """Return the processor time of a call."""
    began = time.process_time()
    what()
    return time.process_time() - began


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=10)
    blocks = parser.parse_args().blocks
    grip_tool(0)  # the network is compiled once
    grips: dict[tuple[float, bool], list[float]] = {(s, each): [] for s in HOLDS_S for each in (True, False)}
    taken: dict[str, list[float]] = {name: [] for name, *_ in MODELS}
    for block in range(blocks):
        for (hold_s, each), spent in grips.items():
            spent.append(
                seconds(lambda block=block, hold_s=hold_s, each=each: grip_tool(block, hold_s, each=each))
            )
        for model in MODELS:
            taken[model[0]].append(seconds(lambda model=model: grip_physics(model)))
    middle = {name: median(each) for name, each in taken.items()}
    print("a whole tool, from its start over a grip to the end of the drop:")
    for hold_s in HOLDS_S:
        one, leaps = median(grips[hold_s, True]), median(grips[hold_s, False])
        ratio = median([a / b for a, b in zip(grips[hold_s, True], grips[hold_s, False], strict=True)])
        print(f"  held for {hold_s:g} s ({grip_tool(0, hold_s):.2f} s of its time):")
        print(f"    each frame played: {one * 1000:.1f} ms, {1 / one:.0f} a second and core")
        print(
            f"    frames that change nothing left out: {leaps * 1000:.1f} ms, {1 / leaps:.0f}; {ratio:.2f} times"
        )
    print("the physics of a grip and a release, at 50 Hz:")
    for name, *_ in MODELS:
        print(f"  {name}: {middle[name] * 1000:.2f} ms")
    print(f"  ratio: {middle['in steps'] / middle['solved']:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
