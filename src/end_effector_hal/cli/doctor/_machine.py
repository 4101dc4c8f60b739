"""Hints about timing: pre-emption of the kernel, load, and lateness of a wake-up."""

from __future__ import annotations

import os
import time
from pathlib import Path

from end_effector_hal.wires import now_us

from ._check_result import CheckedPart, CheckResult, CheckResults

WAKE_UPS, EACH_US = 50, 1_000
_say = CheckedPart("machine")


def look_at_machine(reaction_us: int | None) -> CheckResults:
    """Check the timing of this machine.

    Args:
        reaction_us: D, the reaction bound of the description, µs; None: no comparison.
    """
    yield kernel(os.uname().version, Path("/sys/kernel/realtime").exists())
    yield load(os.getloadavg()[0], len(os.sched_getaffinity(0)))
    yield lateness(worst_wake_up_us(), reaction_us)


def kernel(version: str, realtime: bool) -> CheckResult:
    """Return the finding about the kernel from the text of ``uname -v``."""
    words = version.split()
    if realtime or "PREEMPT_RT" in words:
        return _say.ok("kernel with PREEMPT_RT")
    if preempt := next((word for word in words if word.startswith("PREEMPT")), ""):
        return _say.ok(f"kernel with {preempt}; not a real-time kernel")
    return _say.warning(
        "kernel without pre-emption: a wake-up may come milliseconds late",
        "Take a kernel with PREEMPT or PREEMPT_RT if the reaction bound is missed.",
    )


def load(average: float, processors: int) -> CheckResult:
    """Return the finding about the load average of the last minute."""
    text = f"load {average:.1f} on {processors} processor{'s' if processors > 1 else ''}"
    if average <= processors:
        return _say.ok(text)
    return _say.warning(text, "See with top what takes the time; deadlines are kept later under load.")


def lateness(worst_us: int, reaction_us: int | None) -> CheckResult:
    """Compare the worst lateness of a wake-up with D; the tool needs a part of D for itself."""
    text = f"worst of {WAKE_UPS} wake-ups {worst_us / 1000:.1f} ms late"
    if reaction_us is None:
        return _say.ok(text)
    text += f"; the reaction bound is {reaction_us / 1000:g} ms"
    if 2 * worst_us <= reaction_us:
        return _say.ok(text)
    return _say.warning(
        text, "Lower the load, or declare a bounds.reaction_ms that the machine keeps and verify again."
    )


def worst_wake_up_us() -> int:
    """Measure the lateness of wake-ups for 50 ms and return the largest, µs."""
    worst = 0
    for _ in range(WAKE_UPS):
        due = now_us() + EACH_US
        time.sleep(EACH_US / 1e6)
        worst = max(worst, now_us() - due)
    return worst
