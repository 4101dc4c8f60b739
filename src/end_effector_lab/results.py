"""A new folder for results, and the checksum of the program that computes them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from end_effector_hal.cli import the_folder
from end_effector_hal.errors import UsageError, os_errors

PACKAGES = ("timed_automata", "end_effector_hal", "end_effector_lab")


@cache
def source_checksum() -> str:
    """Return 12 hex digits of the hash of all files of the packages.

    In a checkout the source changes while the version stays the same.
    """
    found = sha256()
    for package in PACKAGES:
        spec = find_spec(package)
        for folder in (spec and spec.submodule_search_locations) or ():
            for file in sorted(Path(folder).rglob("*")):
                if file.suffix != ".pyc" and file.is_file():
                    found.update(f"{package}/{file.relative_to(folder)}\0".encode())
                    found.update(sha256(file.read_bytes()).digest())
    return found.hexdigest()[:12]


def new_results(path: Path) -> Path:
    """Make a folder, and return it; raises UsageError if it holds anything: no results are mixed or overwritten."""
    folder = the_folder(path)
    with os_errors("The folder cannot be read", folder):
        held = next(iter(sorted(folder.iterdir())), None)
    if held is not None:
        what = f"This folder is not empty: it holds {held.name!r}."
        raise UsageError(what, where=str(path), todo="Name another folder with -o, or move this one away.")
    return folder


def append_line(path: Path, result: Mapping[str, object]) -> None:
    """Append a result to a file as a line of JSON; raises UsageError if it cannot be written."""
    with os_errors("The file cannot be written", path), path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(result) + "\n")
