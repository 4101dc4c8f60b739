"""Node DataLogger: writes the run folder, one row per change, as it happens."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes._recording_limits import recording_limits
from end_effector_hal.nodes.interface import DIRECTORY, END_EFFECTOR_STATE, SENSOR_FRAME, SUPERVISOR_COMMANDS
from end_effector_hal.nodes.report import ERROR, OK, Health, publish_health
from end_effector_hal.nodes.transport import (
    CommandMessage,
    FrameMessage,
    NodeTransport,
    StampCheck,
    StateMessage,
)
from end_effector_hal.recording import Recording
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._commands_log import CommandsLog
from ._rows import write_frame, write_state


class DataLogger:
    """Translates messages to rows; a row that cannot be written is reported once in the log, and in the diagnostics."""

    def __init__(self, node: NodeTransport) -> None:
        description, self._log = node.description(), node.log
        folder = Path(node.parameter(DIRECTORY) or f"runs/{datetime.now():%Y%m%d-%H%M%S}").expanduser()
        self._recording = Recording(folder, description, ros=node.generation, limits=recording_limits(node))
        node.on_end(self._recording.close)
        self._commands = CommandsLog(folder, self._recording.seconds)
        node.on_end(self._commands.close)
        self._state_stamps = StampCheck("States of the end-effector", node.log)
        self._frame_stamps = StampCheck("Sensor frames", node.log)
        self._trouble = ""
        node.subscribe(END_EFFECTOR_STATE, self._on_state)
        node.subscribe(SENSOR_FRAME, self._on_frame)
        node.subscribe(SUPERVISOR_COMMANDS, self._on_command)
        publish_health(node, description.name, self._health)
        node.log.info("recording into %s", folder.absolute())

    def _on_state(self, message: StateMessage) -> None:
        if self._state_stamps.accepts(message.at_us):
            self._write(lambda: write_state(self._recording, message))

    def _on_frame(self, message: FrameMessage) -> None:
        if self._frame_stamps.accepts(message.at_us):
            self._write(lambda: write_frame(self._recording, message))

    def _on_command(self, message: CommandMessage) -> None:
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
                self._log.warning("rows are written again; run.json lists the missing ones")
            self._trouble = ""

    def _health(self) -> Health:
        return Health(ERROR if self._trouble else OK, self._trouble or "As it should be.")
