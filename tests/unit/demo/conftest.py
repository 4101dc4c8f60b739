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
    """Writes each status as a row, the commands of both programs in one column."""

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
        while self.status.ee in MOVING or self.change.status().command != Command.NONE:
            assert self.at < end, "it never ends"
            self.run(0.02)

    def _gripper(self, statuses: list[Status]) -> None:
        for status in statuses:
            super()._gripper([status])
            changing = self.change.status().command
            self._row(status, status.command if status.command != Command.NONE else changing, status.at)
            self._write_events(status)

    def _changer(self, statuses: list[Status]) -> None:
        for status in statuses:
            super()._changer([status])
            gripping = self.grip.status()
            command = gripping.command if gripping.command != Command.NONE else status.command
            self._row(gripping, command, status.at)
            self._write_events(status)

    def _write_events(self, status: Status) -> None:
        self._events.write(
            [event_row(each, each.at / 1e6, self.description.sequence) for each in status.events]
        )

    def _row(self, status: Status, command: int, at: int) -> None:
        self._writer.write(at / 1e6, status.ee, command, status.actuators)


@pytest.fixture(scope="session")
def recordings(verdin: Description, tmp_path_factory: pytest.TempPathFactory) -> dict[str, StatesLog]:
    """By the name of the scenario."""
    found = {}
    for scenario in scenarios(verdin, everything=True):
        states = tmp_path_factory.mktemp(scenario.name) / "states.csv"
        RecordedTool(verdin, scenario.bench, states).play(scenario)
        found[scenario.name] = read_states(states)
    return found
