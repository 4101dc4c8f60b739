"""What must be the same for a computation to go on with the results of an earlier one."""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import os_errors
from end_effector_hal.recording import product_version

PACKAGES = ("timed_automata", "end_effector_hal", "end_effector_lab")


def mark_of(description: Description, **more: object) -> dict[str, object]:
    """The tool, its UPPAAL file and the program, and what the computation adds, such as a seed.

    Plug-ins of other distributions are not in it: who changes one names another folder.
    """
    path = description.automata_path
    with os_errors("The UPPAAL file cannot be read", path):
        automata = sha256(path.read_bytes()).hexdigest()[:12]
    return {
        "tool": description.name,
        "description": description.fingerprint(),
        "automata": automata,
        "version": product_version(),
        "source": source_checksum(),
    } | more


@cache
def source_checksum() -> str:
    """Twelve hex digits of every file of the packages: in a checkout the version stays while the source changes."""
    found = sha256()
    for package in PACKAGES:
        spec = find_spec(package)
        for folder in (spec and spec.submodule_search_locations) or ():
            for file in sorted(Path(folder).rglob("*")):
                if file.suffix != ".pyc" and file.is_file():
                    found.update(f"{package}/{file.relative_to(folder)}\0".encode())
                    found.update(sha256(file.read_bytes()).digest())
    return found.hexdigest()[:12]
