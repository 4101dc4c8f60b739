"""What must be the same on both sides before work is sent: two versions of a program would mix their results."""

from __future__ import annotations

import platform
from functools import cache

from end_effector_hal.recording import product_version
from end_effector_lab.results import source_checksum


@cache
def identity() -> dict[str, str]:
    """Names of what must be equal, with what this process has."""
    return {
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "end-effector-hal": product_version(),
        "the source of end-effector-hal": source_checksum(),
    }


def differences(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """A phrase for each name that differs; empty: none does."""
    return "; ".join(
        f"{name} is {theirs.get(name) or 'missing'} there, {value or 'missing'} here"
        for name, value in ours.items()
        if theirs.get(name) != value
    )
