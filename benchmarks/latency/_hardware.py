"""The hardware of the demo, with a testbench that records the times of all frames and edges."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_lab.demo import World


class Hardware(World):
    """A virtual chip, its line arbiter, and the testbench; ``saw`` is the testbench's file of events.

    Args:
        description: the tool.
        folder: receives logs and events.
    """

    def __init__(self, description: Description, folder: Path) -> None:
        super().__init__(description, "nominal", folder, events="events.jsonl")
        self.saw = folder / "events.jsonl"

    def phase_us(self) -> int:
        """Return the phase of the testbench's frames within their period; the floor uses another phase."""
        with self.saw.open("rb") as file:
            file.seek(max(0, self.saw.stat().st_size - 4096))
            line = [line for line in file.read().splitlines()[:-1] if b'"frame"' in line][-1]
        return int(line.split(b",", 1)[0].split(b":")[1]) % 20_000
