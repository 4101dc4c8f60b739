"""``make bench``: latencies against their floor, processor time, memory, the line arbiter, verification."""

from __future__ import annotations

import argparse
import json
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import latency
import verification
from aims import aims
from arbiter_cost import measure_arbiter
from environments import environment
from machine import load_now, machine
from rich.console import Console
from table import print_arbiter, print_latencies, print_usage, print_verification

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ReportedError, RosError

PARTS = {
    "core": "without ROS",
    "ros": "through ROS 1",
    "ros2-one": "through ROS 2, one process",
    "ros2-five": "through ROS 2, five processes",
}
OTHERS = ("arbiter", "verification")
progress, console = Console(stderr=True, highlight=False), Console(width=150, highlight=False)


def main() -> int:
    arguments = _arguments()
    begun, plan = time.monotonic(), latency.QUICK if arguments.quick else latency.FULL
    written: dict[str, Any] = {"machine": machine(), "quick": arguments.quick}
    written |= _in_turns([part for part in PARTS if part in arguments.parts], plan)
    if "arbiter" in arguments.parts:
        cost = measure_arbiter(*((5, 5.0) if arguments.quick else (30, 20.0)), _say("arbiter"))
        print_arbiter(console, cost)
        written["arbiter"] = cost.as_json()
    if "verification" in arguments.parts:
        measured = verification.measure_verification(
            verification.QUICK if arguments.quick else verification.FULL, _say("verification")
        )
        print_verification(console, measured)
        written["verification"] = measured.as_json()
    written["machine"]["load_after"] = load_now()
    written["aims"] = aims(written)
    written["seconds"] = time.monotonic() - begun
    for aim in written["aims"]:
        console.print(f"{'met   ' if aim['met'] else 'MISSED'} {aim['text']}: {aim['measured']}")
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(written, indent=1) + "\n", encoding="utf-8")
    load = f"load {written['machine']['load'][0]:.1f} before, {load_now():.1f} after"
    console.print(f"{written['seconds']:.0f} s, {load}; {arguments.output}")
    return 0


def _in_turns(parts: Sequence[str], plan: latency.Plan) -> dict[str, Any]:
    """Measure all parts in each round, so that other load affects all of them."""
    parts = [part for part in parts if _is_here(part)]
    results: dict[str, latency.Result] = {}
    for number in range(plan.rounds):
        for part in parts if number % 2 == 0 else reversed(parts):
            say = _say(f"round {number + 1} of {plan.rounds}, {PARTS[part]}")
            try:
                result = _measure(part, plan, say)
            except ReportedError as error:
                say(f"left out: {error}")
                continue
            if part in results:
                results[part].add(result)
            else:
                results[part] = result
    if missing := [PARTS[part] for part in parts if part not in results]:
        raise ReportedError(
            f"No round could be measured: {', '.join(missing)}.", todo="Is the machine very busy?"
        )
    for part in parts:
        where, result = PARTS[part], results[part]
        print_latencies(console, f"Latencies {where}", result)
        print_usage(console, f"Use while holding at 50 Hz, {where}", result.usage)
        print_usage(console, f"Use of the floor at 50 Hz, {where}", result.floor_usage)
    return {part: results[part].as_json() for part in parts}


def _is_here(part: str) -> bool:
    try:
        environment(part)
    except RosError as error:
        progress.print(f"{PARTS[part]}: left out. {error}")
        return False
    return True


def _measure(part: str, plan: latency.Plan, say: Callable[[str], None]) -> latency.Result:
    folder = Path(tempfile.mkdtemp(prefix="eehal-bench-"))
    try:
        result = latency.measure(load(profile_path()), folder, plan, say, part)
    except BaseException:
        say(f"the logs are in {folder}")
        raise
    shutil.rmtree(folder)
    return result


def _say(part: str) -> Any:
    return lambda text: progress.print(f"{part}: {text}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="six minutes: see that it works")
    parser.add_argument(
        "--only",
        "--parts",
        dest="parts",
        nargs="+",
        choices=[*PARTS, *OTHERS],
        default=[*PARTS, *OTHERS],
        help="some of it; arbiter and verification need no ROS",
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("runs/bench.json"))
    return parser.parse_args()


if __name__ == "__main__":
    # an end by `timeout` ends every process that was started, too
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        sys.exit(main())
    except ReportedError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)
