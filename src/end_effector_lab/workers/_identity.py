"""What must be the same on both sides before work is sent: two versions of a program would mix their results."""

from __future__ import annotations

import platform
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from end_effector_hal.recording import product_version

PACKAGES = ("timed_automata", "end_effector_hal", "end_effector_lab")


@cache
def identity() -> dict[str, str]:
    """Names of what must be equal, with what this process has."""
    return {
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "end-effector-hal": product_version(),
        "the source of end-effector-hal": _source(),
    }


def differences(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """A phrase for each name that differs; empty: none does."""
    return "; ".join(
        f"{name} is {theirs.get(name) or 'missing'} there, {value or 'missing'} here"
        for name, value in ours.items()
        if theirs.get(name) != value
    )


def _source() -> str:
    """A checksum of every file of the packages: in a checkout the version stays while the source changes."""
    found = sha256()
    for package in PACKAGES:
        spec = find_spec(package)
        for folder in (spec and spec.submodule_search_locations) or ():
            for file in sorted(Path(folder).rglob("*")):
                if file.is_file() and file.suffix != ".pyc":
                    found.update(f"{package}/{file.relative_to(folder)}\0".encode())
                    found.update(file.read_bytes())
    return found.hexdigest()[:12]
