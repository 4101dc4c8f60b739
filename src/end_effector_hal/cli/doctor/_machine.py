"""Checks the interpreter, this distribution and its dependencies, and gives hints about timing."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import time
from importlib import metadata
from pathlib import Path

from end_effector_hal._extras import DISTRIBUTION, command_for, extras, version_of
from end_effector_hal.wires import now_us

from ._check_result import CheckedPart, CheckResult, CheckResults

_NEEDED_BY = {
    "bags": "`eehal import`",
    "cluster": "work that is shared out to other machines (`--scheduler`)",
    "lab": "figures, simulations and trials",
    "modbus": "the codecs modbus-rtu-*",
    "page": "`eehal page`",
    "recordings": "`eehal replay`, `eehal page RECORDING` and the index of a trace",
}
_DEBIAN = "/usr/lib/python3/dist-packages"
WAKE_UPS, EACH_US = 50, 1_000
_say, _say_of_timing = CheckedPart("python"), CheckedPart("machine")


def look_at_python() -> CheckResults:
    """Check the version, the packages, and an environment variable that breaks them."""
    version = ".".join(map(str, sys.version_info[:3]))
    yield _say.ok(f"Python {version} at {sys.executable}")
    try:
        own = metadata.distribution(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        yield _say.missing(f"{DISTRIBUTION} is not installed here", "pip install . in a virtual environment")
        return
    absent = sorted(name for name in _needed(own) if not version_of(name))
    if absent:
        yield _say.missing(
            f"{DISTRIBUTION} {own.version}, without {', '.join(absent)}", f"pip install {' '.join(absent)}"
        )
    else:
        yield _say.ok(f"{DISTRIBUTION} {own.version}")
    for extra, packages in extras().items():
        if not all(map(version_of, packages)):
            yield _say.warning(
                f"the extra {extra} is not installed ({', '.join(packages)})",
                f"Needed by {_NEEDED_BY[extra]} only: {command_for(extra)}",
            )
    if _DEBIAN in os.environ.get("PYTHONPATH", "").split(":"):
        yield _say.warning(
            f"PYTHONPATH names {_DEBIAN}: Debian's packages hide newer ones of this environment",
            "Take it out; make the environment with python3 -m venv --system-site-packages.",
        )


def _needed(own: metadata.Distribution) -> list[str]:
    names = []
    for requirement in own.requires or []:
        name = re.match(r"[\w.-]+", requirement)
        if name and "extra ==" not in requirement:
            names.append(name[0])
    return names


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
        return _say_of_timing.ok("kernel with PREEMPT_RT")
    if preempt := next((word for word in words if word.startswith("PREEMPT")), ""):
        return _say_of_timing.ok(f"kernel with {preempt}; not a real-time kernel")
    return _say_of_timing.warning(
        "kernel without pre-emption: a wake-up may come milliseconds late",
        "Take a kernel with PREEMPT or PREEMPT_RT if the reaction bound is missed.",
    )


def load(average: float, processors: int) -> CheckResult:
    """Return the finding about the load average of the last minute."""
    text = f"load {average:.1f} on {processors} processor{'s' if processors > 1 else ''}"
    if average <= processors:
        return _say_of_timing.ok(text)
    return _say_of_timing.warning(
        text, "See with top what takes the time; deadlines are kept later under load."
    )


def lateness(worst_us: int, reaction_us: int | None) -> CheckResult:
    """Compare the worst lateness of a wake-up with D; the tool needs a part of D for itself."""
    text = f"worst of {WAKE_UPS} wake-ups {worst_us / 1000:.1f} ms late"
    if reaction_us is None:
        return _say_of_timing.ok(text)
    text += f"; the reaction bound is {reaction_us / 1000:g} ms"
    if 2 * worst_us <= reaction_us:
        return _say_of_timing.ok(text)
    return _say_of_timing.warning(
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


def is_importable(name: str) -> bool:
    """Return whether a module can be imported, even if its package is absent; only the packages that contain it are
    imported.
    """
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        return False
