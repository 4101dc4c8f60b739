"""DataLogger: writes the run folder, a row per change, as it happens."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any

from end_effector_hal.errors import EndEffectorError
from end_effector_hal.tool import Recording
from end_effector_hal.trace import Command
from end_effector_hal.wires import now_us

from ._commands_log import CommandsLog
from ._node import Node
from ._stamped import Stamped
from ._table import DATA_LOGGER, DIRECTORY, END_EFFECTOR_STATE, SENSOR_FRAME, SUPERVISOR_COMMANDS


class DataLogger:
    """Translates messages to rows.

    Args:
        node: it listens through this.
        recording: takes states and pressures.
        commands: takes what the Supervisor gives.
    """

    def __init__(self, node: Node, recording: Recording, commands: CommandsLog) -> None:
        self._recording, self._commands, self._log = recording, commands, node.log
        self._stamped_states = Stamped("States of the end-effector", node.log)
        self._stamped_frames = Stamped("Sensor frames", node.log)
        node.subscribe(END_EFFECTOR_STATE, self._state_came)
        node.subscribe(SENSOR_FRAME, self._frame_came)
        node.subscribe(SUPERVISOR_COMMANDS, self._command_came)

    def _state_came(self, message: Any) -> None:
        if not self._stamped_states.counts(message.at_us):
            return
        try:
            self._recording.state(message.at_us, message.state, message.command, message.actuators)
            self._recording.alarms(message.at_us, message.alarms)
        except EndEffectorError as error:
            self._log.error("%s", error)

    def _frame_came(self, message: Any) -> None:
        if not self._stamped_frames.counts(message.at_us):
            return
        values = {
            channel: value if valid else None
            for channel, value, valid in zip(message.channels, message.values, message.valid, strict=False)
        }
        try:
            self._recording.values(message.at_us, values)
        except EndEffectorError as error:
            self._log.error("%s", error)

    def _command_came(self, message: Any) -> None:
        self._commands.write(now_us(), Command(message.command))


def main(argv: list[str]) -> int:
    """Run the node until it is told to end."""
    node = Node(DATA_LOGGER, argv)
    description = node.description()
    folder = Path(node.parameter(DIRECTORY) or f"runs/{datetime.now():%Y%m%d-%H%M%S}").expanduser()
    with (
        Recording(folder, description, ros=True) as recording,
        CommandsLog(folder, recording.seconds) as commands,
    ):
        DataLogger(node, recording, commands)
        node.log.info("recording into %s", folder.absolute())
        return node.spin()
