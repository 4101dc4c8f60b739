"""The targets, and whether the results meet them. Nothing depends on that, since a busy machine misses them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

ONE_CPU_PERCENT, ONE_MEMORY_MB, OF_CORE = 6.0, 130.0, 1.3
"""Targets for ROS 2 in one process; the last is the ratio of its reaction to that without ROS."""
RATIO, P99_MS, CPU_PERCENT, MEMORY_MB, REQUIREMENTS_S, GROWTH = 1.5, 5.0, 15.0, 250.0, 1.0, 2.0
FISCHER_8_S, STATE_BYTES, FISCHER_10_KIB = 2.5, 1024, 4 * 1024 * 1024
ADDED_US = 150.0
ARBITER = "line arbiter"  # no node, but no node works without it


def aims(written: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return, for each target that was measured: its text, the result in words, and whether it is met."""
    found: list[dict[str, Any]] = []

    def aim(text: str, value: float, most: float, words: str) -> None:
        found.append({"text": text, "measured": words, "met": value <= most})

    for part, where in (
        ("core", "without ROS"),
        ("ros", "through ROS 1"),
        ("ros2-one", "through ROS 2, one process"),
        ("ros2-five", "through ROS 2, five processes"),
    ):
        result = written.get(part)
        if not result:
            continue
        for name in ("reaction", "command", "state"):
            ratio = result["latencies_us"][name]["ratio_of_medians"]
            aim(f"{name} {where}: median at most {RATIO} x the floor", ratio, RATIO, f"{ratio:.2f} x")
        p99 = result["latencies_us"]["reaction"]["product"]["p99"] / 1000
        aim(f"reaction {where}: p99 under {P99_MS:g} ms on an idle machine", p99, P99_MS, f"{p99:.2f} ms")
        if part == "ros2-five":
            continue
        one = part == "ros2-one"
        for field, unit, most, text in (
            ("cpu_percent", 1.0, ONE_CPU_PERCENT if one else CPU_PERCENT, "% of a core"),
            ("pss_kib", 1024 / 1e6, ONE_MEMORY_MB if one else MEMORY_MB, "MB (PSS)"),
        ):
            arbiter = result["usage"][ARBITER][field] * unit
            nodes = sum(each[field] for each in result["usage"].values()) * unit - arbiter
            words = f"{nodes:.1f} {text}, with the line arbiter {nodes + arbiter:.1f}"
            aim(f"all nodes {where}: under {most:g} {text} while holding", nodes, most, words)
    if (core := written.get("core")) and (one_process := written.get("ros2-one")):
        medians = [each["latencies_us"]["reaction"]["product"]["median"] for each in (one_process, core)]
        times = medians[0] / medians[1]
        text = f"reaction through ROS 2, one process: at most {OF_CORE:g} x that without ROS"
        aim(text, times, OF_CORE, f"{times:.2f} x")
    if cost := written.get("arbiter"):
        added = cost["added_us"]
        aim(
            f"the line arbiter adds at most {ADDED_US:g} µs at the median", added, ADDED_US, f"{added:.0f} µs"
        )
    if measured := written.get("verification"):
        seconds = sum(answer["seconds"] for answer in measured["together"]["answers"])
        finished = measured["together"]["finished"]
        words = f"{seconds:.1f} s" if finished else "not finished in their time"
        text = f"all requirements of the shipped tool under {REQUIREMENTS_S:g} s"
        aim(text, seconds if finished else float("inf"), REQUIREMENTS_S, words)
        if (growth := measured["growth_exponent"]) is not None:
            aim(f"cost grows at most as steps^{GROWTH:g}", growth, GROWTH, f"steps^{growth:.2f}")
        fischer = {each["size"]: each for each in measured["fischer"] if each["finished"]}
        if eight := fischer.get(8):
            seconds = sum(answer["seconds"] for answer in eight["answers"])
            aim(f"Fischer 8 under {FISCHER_8_S:g} s", seconds, FISCHER_8_S, f"{seconds:.1f} s")
            each = eight["bytes_per_state"]
            aim(
                f"Fischer 8: at most {STATE_BYTES} bytes for a stored state", each, STATE_BYTES, f"{each:.0f}"
            )
        if ten := fischer.get(10):
            peak = ten["peak_kib"]
            aim("Fischer 10 within 4 GiB", peak, FISCHER_10_KIB, f"{peak / 1024:.0f} MiB")
    return found
