"""The FMEAs of the shipped tool and of the examples, in ``docs/reference/fmea``: ``python -m tests.support.fmea``.

With names of tools it plays these only.
"""

from __future__ import annotations

import csv
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from end_effector_hal.description import Description, load, profile_path
from end_effector_lab.trials import Cell, cells_of, moments, thinned

from .places import DOCS, ROOT, WRITTEN_OUT

KEPT = DOCS / "reference" / "fmea"
PLAYED = ROOT / "runs" / "fmea"
ONLY = "+ none"
"""Cells without a command: the others are no failure modes."""
EVERY: Mapping[str, int] = {
    "verdin_gripper": 5,
    "area_gripper": 24,
    "bistable_and_magnet": 1,
    "diy_record": 8,
    "diy_text": 4,
    "diy_vacuum": 1,
    "double_acting_jaw": 1,
    "epick_commanded": 2,
    "gripper_2f85": 3,
    "remote_changer": 12,
    "remote_io": 10,
    "six_cups": 16,
    "two_coil_changer": 3,
    "two_epick": 9,
    "two_links": 6,
}
"""One cell of so many is played, by the name of the tool: some hundred."""
HEAD = ("tool", "FMEA", "cells played", "failure modes", "not explained", "how to play it again")


def path_of(name: str) -> Path:
    """The description of a tool; with the registers of a device written out, so that what it says is played."""
    if name == "verdin_gripper":
        return profile_path()
    if (written_out := WRITTEN_OUT / f"{name}.yaml").is_file():
        return written_out
    return ROOT / "examples" / "tools" / name / "end_effector.yaml"


def chosen(name: str) -> tuple[Description, list[Cell], int]:
    """The tool, the cells that are played, and of how many."""
    description = load(path_of(name))
    every = [cell for cell in cells_of(description, moments(description)) if ONLY in cell.id]
    return description, thinned(every, EVERY[name]), len(every)


def fmea_page() -> str:
    """A line for each tool, by its kept FMEA."""
    lines = [HEAD, ("---",) * len(HEAD), *(tuple(_cells(name)) for name in EVERY)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cells(name: str) -> Iterator[str]:
    rows = rows_of(name)
    yield name
    yield f"[{name}.csv](fmea/{name}.csv)"
    yield str(sum(int(row["cells"]) for row in rows))
    yield str(len({(row["item"], row["failure mode"]) for row in rows}))
    yield str(sum(int(row["unexplained"]) for row in rows))
    tool = "" if name == "verdin_gripper" else f" {path_of(name).relative_to(ROOT)}"
    command = f'eehal matrix{tool} --only "{ONLY}" --every {EVERY[name]} -o runs/fmea/{name}'
    yield f"`{command}`"


def rows_of(name: str) -> list[dict[str, str]]:
    """The kept FMEA."""
    with (KEPT / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def main(names: list[str]) -> int:
    """Play tools and keep their FMEAs."""
    for name in names or EVERY:
        folder = PLAYED / name
        shutil.rmtree(folder, ignore_errors=True)
        tool = [] if name == "verdin_gripper" else [str(path_of(name))]
        asked = ["--only", ONLY, "--every", str(EVERY[name]), "-o", str(folder)]
        ended = subprocess.run(["eehal", "matrix", *tool, *asked], check=False).returncode
        if ended not in (0, 4):
            return ended
        KEPT.mkdir(exist_ok=True)
        table = (folder / "fmea.csv").read_bytes()
        (KEPT / f"{name}.csv").write_bytes(table.replace(b"\r\n", b"\n"))  # as all text in this repository
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
