"""The client without ROS: it is the HAL itself, and begins again until the line arbiter is there."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from types import SimpleNamespace

from end_effector_hal.control import Status
from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime import EndEffector, Refused
from end_effector_hal.vocabulary import Command
from tests.acceptance.kill_matrix.client import PERIOD_S, Client

COMMANDS = {"lock": Command.LOCK, "unlock": Command.UNLOCK, "grip": Command.GRIP, "drop": Command.RELEASE}


class PlainClient(Client):
    def __init__(self, tool: EndEffector) -> None:
        super().__init__()
        self._tool = tool
        tool.subscribe(self._status)
        threading.Thread(target=self._look, daemon=True).start()

    def send(self, number: int, name: str) -> None:
        if name == "cancel":
            return self.decided(number, accepted=self._tool.cancel().accepted)
        begun = self._tool.begin(COMMANDS[name], os.environ["EEHAL_KILLED_PART"] if name == "grip" else "")
        self.decided(number, accepted=not isinstance(begun, Refused))
        result = begun if isinstance(begun, Refused) else begun.wait()
        self.ended(number, name, result, succeeded=result.succeeded)
        return None

    def _look(self) -> None:
        while True:
            self._heard["HAL"] = time.monotonic()
            self._status(self._tool.status)
            time.sleep(PERIOD_S)

    def _status(self, status: Status) -> None:
        sequence = self._tool.description.sequence
        message = {name: getattr(status, name) for name in ("held", "lift_allowed", "link_up", "reason")}
        self.state_came(
            SimpleNamespace(
                **message,
                state=int(status.ee),
                command=int(status.command),
                actuator=sequence[status.step] if status.step >= 0 else "",
                tool_changer=int(status.changer),
                at_us=status.at,
                evidence=map(int, status.evidence),
                outputs=map(bool, status.outputs),
                alarms=status.alarm_texts,
            )
        )


def opened() -> EndEffector:
    while True:
        try:
            return EndEffector.open(os.environ["EEHAL_KILLED"])
        except ReportedError as error:
            sys.stderr.write(f"{error}\n")
            time.sleep(0.1)


def end(*_: object) -> None:
    raise SystemExit


signal.signal(signal.SIGTERM, end)
with opened() as tool:
    PlainClient(tool).run()
os._exit(0)
