"""What the clients of both generations of ROS have in common: goals as lines in, what is heard as JSON lines out.

A client is a process of its own, none of those that are hit, and ends with its standard input.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from abc import ABC, abstractmethod
from typing import Any

ACTIONS = {"lock": "LockToolChanger", "unlock": "UnlockToolChanger", "grip": "TriggerGrip", "drop": "Drop"}
HEARD = {
    "PressureSupply": "Pressure",
    "PositionToolChanger": "Position",
}
"""A topic of a node, by which it is known to live; nothing waits for Grip and ToolChange, which publish nothing."""
STATE_FIELDS = ("state", "command", "actuator", "held", "lift_allowed", "tool_changer", "link_up", "at_us")
PERIOD_S = 0.05


class Client(ABC):
    """Gives goals, and tells what it hears."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._heard: dict[str, float] = {}
        self._state: dict[str, Any] = {}

    @abstractmethod
    def send(self, number: int, name: str) -> None:
        """Send a goal, and call `ended` at its end; in a thread of its own."""

    def run(self) -> None:
        """Until the end of standard input."""
        threading.Thread(target=self._repeat, daemon=True).start()
        for line in sys.stdin:
            number, name = line.split()
            threading.Thread(target=self.send, args=(int(number), name), daemon=True).start()

    def decided(self, number: int, *, accepted: bool) -> None:
        """A goal was accepted, or refused."""
        self._say(decided=number, accepted=accepted)

    def ended(self, number: int, name: str, result: Any, *, succeeded: bool) -> None:
        """A goal has ended; ``result`` may be None."""
        told = {"outcome": -1, "reason": ""} if result is None else {
            "outcome": result.outcome, "reason": result.reason,
        }  # fmt: skip
        self._say(goal=number, name=name, succeeded=succeeded, **told)

    def came(self, message: Any, node: str) -> None:
        """A message of a node."""
        del message
        self._heard[node] = time.monotonic()

    def state_came(self, message: Any) -> None:
        """A message of HALMain."""
        if message.state:  # it has adopted its lines
            self._heard["HALMain"] = time.monotonic()
        state = {name: getattr(message, name) for name in STATE_FIELDS}
        state |= {"evidence": list(message.evidence), "outputs": list(message.outputs)}
        state |= {"alarms": list(message.alarms), "reason": message.reason}
        if {**state, "alarms": 0} != {**self._state, "alarms": 0}:
            self._say(change=state)
        self._state = state

    def _say(self, **fields: Any) -> None:
        with self._lock:
            sys.stdout.write(json.dumps(fields) + "\n")
            sys.stdout.flush()

    def _repeat(self) -> None:
        while True:
            time.sleep(PERIOD_S)
            self._say(heard=dict(self._heard), state=self._state)
