"""Node DataLogger: writes the run folder, one row per change, as it happens."""

from __future__ import annotations

import csv
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from end_effector_hal._closing import Closing
from end_effector_hal.control import EventKind, ToolEvent
from end_effector_hal.errors import ReportedError, UsageError, os_errors
from end_effector_hal.owned import open_owned
from end_effector_hal.recording import Recording, event_row
from end_effector_hal.signals import Frame, StampGate
from end_effector_hal.vocabulary import LONGEST_NAME, Cause, Command, printable, received_alarms
from end_effector_hal.wires import now_us

from .interface import DATA_LOGGER, DIRECTORY, END_EFFECTOR_STATE, SUPERVISOR_COMMANDS
from .report import ERROR, OK, Health, publish_health
from .start import recording_limits
from .transport import CommandMessage, NodeTransport, StateMessage

HEADER = "time_s,command,part\n"


class CommandsLog(Closing):
    """Writes one row per command: seconds since the start of the recording, the integer of Table II, and the name of
    the part that a grip is for.

    Args:
        folder: the folder of the recording; an existing file is continued.
        seconds: converts µs on the monotonic clock to the recording's time.

    Raises:
        UsageError: the file cannot be written.
    """

    def __init__(self, folder: Path, seconds: Callable[[int], float]) -> None:
        path = folder / "commands.csv"
        self._seconds, self._lock = seconds, threading.Lock()
        with os_errors("Cannot be written", path):
            fd = open_owned(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            self._file = os.fdopen(
                fd, "a", encoding="utf-8", buffering=1
            )  # a kill loses the last row at most
            if self._file.tell() == 0:
                self._file.write(HEADER)
            self._rows = csv.writer(self._file, lineterminator="\n")

    def write(self, at: int, command: Command, part: str) -> None:
        """Write a command that was given at ``at`` (µs); after an OSError the row is written with the next one."""
        row = (f"{self._seconds(at):.6f}", int(command), printable(part, LONGEST_NAME))
        with self._lock:
            self._rows.writerow(row)

    def close(self) -> None:
        """Close the file; rows that cannot be written any more are lost."""
        with self._lock, suppress(OSError):
            self._file.close()


def write_state(recording: Recording, message: StateMessage) -> None:
    """Write the rows of a state message; raises ReportedError when they cannot be written now."""
    recording.state(message.at_us, message.state, message.command, message.actuators)
    recording.tool_changer(message.at_us, message.tool_changer)
    recording.alarms(message.at_us, received_alarms(message.alarms, message.alarm_ids))
    try:
        events = events_of(message)
    except ValueError as error:
        raise UsageError(f"The state message contains an invalid event: {error}.") from None
    recording.events(message.at_us, events)
    recording.part(message.at_us, message.part)


def events_of(message: StateMessage) -> list[ToolEvent]:
    """Return the events that a state message carries; raises ValueError for an invalid event."""
    names = ("", *message.actuator_names)
    found: list[ToolEvent] = []
    for each in message.events:
        kind, place, cause = EventKind(each.event), names.index(each.actuator) - 1, Cause(each.cause)
        states = each.old_state, each.new_state
        found.append(ToolEvent(each.at_us, kind, place, each.attempt, *states, cause, each.command))
        event_row(found[-1], 0.0, names[1:])
    return found


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
