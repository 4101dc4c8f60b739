"""The cost of judging one frame, depending on what the processor did since the frame before.

``python benchmarks/cold.py [DESCRIPTION]`` judges frames of a tool at rest: in a loop, after a pause, and after this
process has touched enough other memory to displace the program from the caches. The result shows how much of a
reaction is spent on loading the program from memory. Run it on a quiet machine, on one core (``taskset -c 1``).
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from calls import AT_REST

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.sensing import SensorState
from end_effector_hal.signals import Frame
from end_effector_hal.wires import now_us, tune_interpreter

LOOP, PAUSED = 2000, 100
MIB = 1 << 20
LINE = 64
"""Size of a cache line, bytes."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("description", nargs="?", type=Path, default=profile_path("verdin_gripper"))
    description = load(parser.parse_args().description)
    carrier = carrier_of(description)
    state = SensorState(description, carrier)
    values = {channel: AT_REST[channel] for channel in carrier.channels if channel in AT_REST}

    def judge() -> float:
        frame = Frame(now_us(), None, None, values)
        begun = time.perf_counter_ns()
        for _ in state.take(frame):
            pass
        return (time.perf_counter_ns() - begun) / 1000

    for _ in range(LOOP):
        judge()
    tune_interpreter()
    other = bytes(64 * MIB)
    print("judging a frame, median in µs")
    _tell("in a loop", judge, lambda: None, LOOP)
    for ms in (2, 20):
        _tell(f"after {ms} ms of sleep", judge, partial(time.sleep, ms / 1000))
    for mib in (1, 4, 64):
        _tell(f"after {mib} MiB of other memory", judge, partial(_touch, other, mib))
    return 0


def _tell(what: str, judge: Callable[[], float], before: Callable[[], None], count: int = PAUSED) -> None:
    took = []
    for _ in range(count):
        before()
        took.append(judge())
    print(f"  {what:<30}{statistics.median(took):6.0f}")


def _touch(memory: bytes, mib: int) -> None:
    sum(memory[: mib * MIB : LINE])


if __name__ == "__main__":
    raise SystemExit(main())
