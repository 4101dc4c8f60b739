"""The driver's side of the client: gives goals, and knows what was heard."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from end_effector_lab.processes import Child, Children
from tests.acceptance.kill_matrix.waiting import until

SUCCEEDED = 5


class Hands:
    """Talks with one client process; everything it said is in its log file.

    Args:
        client: the module that it runs.
    """

    def __init__(self, children: Children, client: str, log: Path, env: dict[str, str]) -> None:
        command = [sys.executable, "-m", f"tests.acceptance.kill_matrix.{client}"]
        log.unlink(missing_ok=True)
        self.process: Child = children.start("client", command, log=log, env=env, commands=True)
        self._file = log.open(encoding="utf-8")
        self._rest = ""
        self._number = 0
        self.heard: dict[str, float] = {}
        self.state: dict[str, Any] = {}
        self.changes: list[dict[str, Any]] = []
        self.ended: dict[int, dict[str, Any]] = {}
        self.accepted: dict[int, bool] = {}

    def look(self) -> dict[str, Any]:
        """The newest EndEffectorState; empty: none yet."""
        *lines, self._rest = (self._rest + self._file.read()).split("\n")
        for line in lines:
            try:
                said = json.loads(line)
            except ValueError:
                continue  # a warning of ROS
            self.heard = said.get("heard", self.heard)
            self.state = said.get("change") or said.get("state") or self.state
            if "change" in said:
                self.changes.append(said["change"])
            if "decided" in said:
                self.accepted[said["decided"]] = said["accepted"]
            if "goal" in said:
                self.ended[said["goal"]] = said
        return self.state

    def send(self, name: str) -> int:
        """Send a goal; returns its number."""
        self._number += 1
        self.process.tell(f"{self._number} {name}")
        return self._number

    def result(self, number: int) -> dict[str, Any] | None:
        """How it ended, None: it has not."""
        self.look()
        return self.ended.get(number)

    def decision(self, number: int) -> bool:
        """Whether a goal was accepted; waits for it, and only the client without ROS tells it."""
        until("a decision", lambda: self.look() is not None and number in self.accepted)
        return self.accepted[number]

    def run(self, name: str, timeout_s: float = 20.0) -> dict[str, Any]:
        """Send a goal, and wait for its end."""
        number = self.send(name)
        return until(f"the end of {name}", lambda: self.result(number), timeout_s)

    def close(self) -> None:
        """End the client."""
        self.process.end(patience_s=1.0)
        self._file.close()
