"""The cost of a trace: the time from a frame to the resulting status, with and without a trace.

``python benchmarks/recording.py [--blocks N]``. Blocks with and without a trace alternate in the same run, so that
other load affects both. A program runs in real time, with a line arbiter that does nothing; each frame changes a
level, so that each gives a status.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence

from calls import AT_REST

from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime import Program
from end_effector_hal.runtime.boundary import NULL_RECORDER, open_recorder
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import LastWillStep
from end_effector_hal.wires import now_us

FRAMES, WARM_UP, PERIOD_S = 150, 20, 0.02


class _Lines:
    """A line arbiter that does nothing."""

    def levels(self) -> Mapping[str, bool]:
        return {}

    def overtaken(self) -> bool:
        return False

    def ask(self, levels: Mapping[str, bool], will: Sequence[LastWillStep]) -> Callable[[], int]:
        del levels, will
        return lambda: 0

    def close(self, will: Sequence[LastWillStep]) -> None:
        del will


def block(*, recorded: bool) -> list[float]:
    """Return the time from each frame to its status, µs."""
    description, told, done = load(profile_path()), threading.Event(), [0]

    def on_status(_: object) -> None:
        done[0] = time.perf_counter_ns()
        told.set()

    found = []
    with tempfile.TemporaryDirectory() as folder:
        recorder = open_recorder(folder, description) if recorded else NULL_RECORDER
        program = Program(description, _Lines(), on_status, recorder)
        program.start()
        for number in range(FRAMES):
            told.clear()
            begun = time.perf_counter_ns()
            program.frame(
                Frame(now_us(), number, number * 20, AT_REST | {"bottom": -20_000 if number % 2 else 0})
            )
            if told.wait(PERIOD_S * 3 / 4) and number >= WARM_UP:
                found.append((done[0] - begun) / 1000)
            time.sleep(PERIOD_S)
        program.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=8)
    blocks = parser.parse_args().blocks
    times: dict[bool, list[float]] = {False: [], True: []}
    for number in range(2 * blocks):
        times[number % 2 == 1] += block(recorded=number % 2 == 1)
    print(f"{'':16}{'frames':>8}{'median':>10}{'p90':>10}{'p99':>10}  µs")
    for recorded, name in ((False, "without a trace"), (True, "with a trace")):
        found = sorted(times[recorded])
        p90, p99 = (found[int(len(found) * part)] for part in (0.9, 0.99))
        print(f"{name:16}{len(found):8}{statistics.median(found):10.1f}{p90:10.1f}{p99:10.1f}")
    ratio = statistics.median(times[True]) / statistics.median(times[False])
    print(f"ratio of the medians: {ratio:.3f}")


if __name__ == "__main__":
    main()
