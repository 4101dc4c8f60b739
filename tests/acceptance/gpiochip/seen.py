"""What a testbench wrote down of the lines."""

from __future__ import annotations

import json
from pathlib import Path

from end_effector_hal.wires.lines import Edge


def edges_of(events: Path) -> list[Edge]:
    """The edges in the file of ``eehal testbench --events``."""
    entries = [json.loads(line) for line in events.read_text().splitlines()]
    return [
        Edge(each["at"], each["line"], "out", bool(each["level"]), 0) for each in entries if "line" in each
    ]
