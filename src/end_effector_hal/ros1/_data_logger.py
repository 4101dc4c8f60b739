"""DataLogger: writes the run folder, a row per change, as it happens."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from end_effector_hal.errors import ReportedError
from end_effector_hal.recording import Recording
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._commands_log import CommandsLog
from ._diagnostics import ERROR, OK, Health, diagnose
from ._limits import recording_limits
from ._node import Node
from ._stamped import Stamped
from ._table import DATA_LOGGER, DIRECTORY, END_EFFECTOR_STATE, SENSOR_FRAME, SUPERVISOR_COMMANDS


class DataLogger:
    """Translates messages to rows; one that cannot be written is told once, in the log and in the diagnostics.

    Args:
        node: it listens through this.
        recording: takes states and pressures.
        commands: takes what the Supervisor gives.
    """

    def __init__(self, node: Node, recording: Recording, commands: CommandsLog) -> None:
        self._recording, self._commands, self._log = recording, commands, node.log
        self._stamped_states = Stamped("States of the end-effector", node.log)
        self._stamped_frames = Stamped("Sensor frames", node.log)
        self._trouble = ""
        node.subscribe(END_EFFECTOR_STATE, self._state_came)
        node.subscribe(SENSOR_FRAME, self._frame_came)
        node.subscribe(SUPERVISOR_COMMANDS, self._command_came)

    def _state_came(self, message: Any) -> None:
        if not self._stamped_states.counts(message.at_us):
            return

        def write() -> None:
            self._recording.state(message.at_us, message.state, message.command, message.actuators)
            self._recording.alarms(message.at_us, message.alarms)

        self._write(write)

    def _frame_came(self, message: Any) -> None:
        if not self._stamped_frames.counts(message.at_us):
            return
        values = {
            channel: value if valid else None
            for channel, value, valid in zip(message.channels, message.values, message.valid, strict=False)
        }
        self._write(lambda: self._recording.values(message.at_us, values))

    def _command_came(self, message: Any) -> None:
        try:
            self._commands.write(now_us(), Command(message.command))
        except (ValueError, OSError) as error:
            self._log.error("a command could not be written: %s", error)

    def _write(self, write: Callable[[], None]) -> None:
        try:
            write()
        except ReportedError as error:
            if not self._trouble:
                self._log.error("%s", error)
            self._trouble = str(error)
        else:
            if self._trouble:
                self._log.warning("rows are written again; run.json says what is missing")
            self._trouble = ""

    def health(self) -> Health:
        """For the diagnostics."""
        return Health(ERROR if self._trouble else OK, self._trouble or "As it should be.")


def main(argv: list[str]) -> int:
    """Run the node until it is told to end."""
    node = Node(DATA_LOGGER, argv)
    description = node.description()
    folder = Path(node.parameter(DIRECTORY) or f"runs/{datetime.now():%Y%m%d-%H%M%S}").expanduser()
    with (
        Recording(folder, description, ros=True, limits=recording_limits(node)) as recording,
        CommandsLog(folder, recording.seconds) as commands,
    ):
        logger = DataLogger(node, recording, commands)
        diagnose(node, description.name, logger.health)
        node.log.info("recording into %s", folder.absolute())
        return node.spin()
