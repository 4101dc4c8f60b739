"""The hardware of the demo, with a testbench that writes down when each frame and each edge was."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import ArbiterError, LinkError
from end_effector_lab.demo._child import Child
from end_effector_lab.demo._world import EEHAL, START_S, World


class Hardware(World):
    """A virtual chip, its owner, and the testbench; ``events`` is what the testbench saw.

    Args:
        description: the tool.
        folder: receives logs and events.
    """

    owner: Child

    def __init__(self, description: Description, folder: Path) -> None:
        super().__init__(description, "nominal", folder)
        self.folder, self.place, self.events = folder, self._place, folder / "events.jsonl"

    def _start(self) -> None:
        path = str(self.description_path)
        self.testbench = self.children.start(
            "testbench", [*EEHAL, "testbench", path, "--events", str(self.events)],
            log=self.folder / "testbench.log", failed=LinkError, commands=True,
        )  # fmt: skip
        self.testbench.wait_until(
            lambda: "ready:" in self.testbench.text(), timeout_s=START_S, what="it was ready"
        )
        self.owner = self.children.start(
            "line arbiter", [*EEHAL, "arbiter", path], log=self.folder / "owner.log", failed=ArbiterError
        )
        self.owner.wait_until(self.socket.exists, timeout_s=START_S, what="its socket")

    def phase_us(self) -> int:
        """When the frames of the testbench come, within their period; the floor keeps off it."""
        with self.events.open("rb") as file:
            file.seek(max(0, self.events.stat().st_size - 4096))
            line = [line for line in file.read().splitlines()[:-1] if b'"frame"' in line][-1]
        return int(line.split(b",", 1)[0].split(b":")[1]) % 20_000
