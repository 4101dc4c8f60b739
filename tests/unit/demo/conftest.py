"""Recordings of the demo's scenarios, made in virtual time: exact, and quick."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.recording import EventsWriter, StatesLog, StatesWriter, event_row, read_states
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.demo import DemoScenario, scenarios
from tests.support.virtual_tool import VirtualTool

NAMES = {
    Command.LOCK: "lock",
    Command.UNLOCK: "unlock",
    Command.GRIP: "grip",
    Command.RELEASE: "drop",
    Command.CANCEL: "cancel",
}
LONGEST_S = 300.0
MOVING = (EndEffectorState.GRIPPING, EndEffectorState.RELEASING)


class RecordedTool(VirtualTool):
    """Writes each status as a row."""

    def __init__(self, description: Description, bench: str, states: Path) -> None:
        self._writer = StatesWriter(states, description.sequence)
        self._events = EventsWriter(states.with_name("events.csv"), description.sequence)
        super().__init__(description, bench)

    def play(self, scenario: DemoScenario) -> None:
        """Give the orders of a scenario, with its waits."""
        self.run(scenario.rest_s)
        for order in scenario.orders:
            assert self.command(NAMES[order.command]).accepted
            if not order.background:
                self.finish()
            self.run(order.wait_s)
        self._writer.close()
        self._events.close()

    def finish(self) -> None:
        """Until nothing is executed any more."""
        end = self.at + LONGEST_S * 1e6
        while self.status.ee in MOVING or self.status.command != Command.NONE:
            assert self.at < end, "it never ends"
            self.run(0.02)

    def _told(self, statuses: list[Status]) -> None:
        super()._told(statuses)
        for status in statuses:
            self._writer.write(status.at / 1e6, status.ee, status.command, status.actuators)
            self._events.write([event_row(e, e.at / 1e6, self.description.sequence) for e in status.events])


@pytest.fixture(scope="session")
def recordings(verdin: Description, tmp_path_factory: pytest.TempPathFactory) -> dict[str, StatesLog]:
    """By the name of the scenario."""
    found = {}
    for scenario in scenarios(verdin, everything=True):
        states = tmp_path_factory.mktemp(scenario.name) / "states.csv"
        RecordedTool(verdin, scenario.bench, states).play(scenario)
        found[scenario.name] = read_states(states)
    return found
