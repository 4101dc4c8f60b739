"""Node DataLogger: writes the run folder, one row per change, as it happens."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes._recording_limits import recording_limits
from end_effector_hal.nodes.interface import DATA_LOGGER, DIRECTORY, END_EFFECTOR_STATE, SUPERVISOR_COMMANDS
from end_effector_hal.nodes.report import ERROR, OK, Health, publish_health
from end_effector_hal.nodes.transport import CommandMessage, NodeTransport, StateMessage
from end_effector_hal.recording import Recording
from end_effector_hal.signals import Frame, StampGate
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._commands_log import CommandsLog
from ._rows import write_state


class DataLogger:
    """Writes the rows of the states, and of the frames, which come from the HAL itself.

    A row that cannot be written is reported once in the log, and in the diagnostics.
    """

    def __init__(self, node: NodeTransport) -> None:
        tool, self._log = node.tool(), node.log
        description = tool.description
        folder = Path(node.parameter(DIRECTORY) or f"runs/{datetime.now():%Y%m%d-%H%M%S}").expanduser()
        self._recording = Recording(folder, description, ros=node.generation, limits=recording_limits(node))
        node.on_end(self._recording.close)
        self._commands = CommandsLog(folder, self._recording.seconds)
        node.on_end(self._commands.close)
        self._stamps = StampGate("States of the end-effector")
        self._trouble = ""
        node.subscribe(END_EFFECTOR_STATE, self._on_state)
        node.subscribe(SUPERVISOR_COMMANDS, self._on_command)
        tool.subscribe_frames(self._on_frame, name=DATA_LOGGER)
        publish_health(node, description.name, self._health)
        node.log.info("recording into %s", folder.absolute())

    def _on_state(self, message: StateMessage) -> None:
        before, now = self._stamps.refused, now_us()
        if self._stamps.passes(message.at_us, now):
            self._write(lambda: write_state(self._recording, message))
        elif not before:
            self._log.error("%s", " ".join(map(str, self._stamps.notices(now))))

    def _on_frame(self, frame: Frame) -> None:
        if frame.at <= now_us():  # the HAL has refused any other
            self._write(lambda: self._recording.values(frame.at, frame.values))

    def _on_command(self, message: CommandMessage) -> None:
        try:
            self._commands.write(now_us(), Command(message.command), message.part)
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
