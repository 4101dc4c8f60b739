"""The program of the tool with its topic and its internal service."""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from end_effector_hal.control import Answer, Status, event_lines
from end_effector_hal.control.goals import CHANNELS
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes._recording_limits import recording_limits
from end_effector_hal.nodes.interface import (
    ARM,
    COMMAND_VALID_S,
    DIRECTORY,
    GRIP_COMMAND,
    GRIP_STATE,
    SENSOR_FRAME,
    STATE_HZ,
)
from end_effector_hal.nodes.report import ERROR, OK, WARN, Health, log_refusal, publish_health, standing
from end_effector_hal.nodes.transport import (
    FrameMessage,
    MessageHeader,
    NodeTransport,
    StatusMessage,
    status_to_message,
)
from end_effector_hal.runtime import open_program
from end_effector_hal.vocabulary import Alarm, EndEffectorState, alarm_changes
from end_effector_hal.wires import now_us

_WORDS = {**{int(command): word for command, word in CHANNELS.items()}, ARM: "arm"}
"""The commands of the internal service, as the program calls them."""
_ERRORS = (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


class ProgramNode:
    """Publishes the statuses of the program at each step and at 10 Hz, and passes commands to it.

    The program lives as long as the node.
    """

    def __init__(self, node: NodeTransport, description: Description) -> None:
        self._node, self._log = node, node.log
        self._frames = node.frames(description)
        self._publish = node.publisher(GRIP_STATE)
        self._description = description
        self._since_us, self._count = now_us(), 0
        self._lock = threading.Lock()
        self._last: StatusMessage | None = None
        self._alarms: tuple[Alarm, ...] = ()
        folder = node.parameter(DIRECTORY)
        traces = Path(folder).expanduser() if folder else None
        limits = recording_limits(node)
        self.program = open_program(
            description,
            self._on_status,
            traces=traces,
            limits=limits,
        )
        node.serve(GRIP_COMMAND, self._on_command)
        node.every(STATE_HZ, self._repeat)
        publish_health(node, description.name, self._health)
        node.on_close(self._close)
        self.program.start()
        node.on_start(lambda: node.subscribe(SENSOR_FRAME, self._on_frame))

    def _on_frame(self, message: FrameMessage) -> None:
        self.program.frame(self._frames.frame_of(message))

    def _on_status(self, status: Status) -> None:
        with self._lock:
            self._count += 1
            self._last = now = self._with_alarms(
                status_to_message(status, self._since_us, self._count, self._description.sequence),
                status.alarms,
            )
            self._publish(now)
            before, self._alarms = self._alarms, status.alarms
        for line in event_lines(self._description, status):
            self._log.info("%s", line)
        for alarm, change in alarm_changes(before, status.alarms):
            if change != "ended":
                self._log.log(logging.INFO if alarm.over else logging.WARNING, "%s", alarm)

    def _with_alarms(self, message: StatusMessage, alarms: Sequence[Alarm]) -> StatusMessage:
        """Return a message with the alarms of its program and those about unknown senders."""
        every = (*alarms, *self._node.unknown_senders.alarms())
        return replace(message, alarms=tuple(map(str, every)), alarm_ids=tuple(each.name for each in every))

    def _repeat(self) -> None:
        if not self.program.alive:
            self._node.fail(ReportedError("The program of the tool has failed."))
            return
        with self._lock:
            if self._last is not None:
                now = self._with_alarms(self._last, self._alarms)
                self._count += now.alarms != self._last.alarms
                self._last = replace(now, header=MessageHeader(), count=self._count, events=())
                self._publish(self._last)

    def _on_command(self, request: Any) -> Answer:
        answer = self._decide(request)
        if not answer.accepted:
            log_refusal(self._log, _WORDS.get(request.command, f"command {request.command}"), answer)
        with self._lock:
            return replace(answer, count=self._count)

    def _decide(self, request: Any) -> Answer:
        if why := self._node.refuse_unknown_caller(GRIP_COMMAND, request):
            return Answer(False, why)
        if request.command not in _WORDS:
            known = ", ".join(f"{word} ({command})" for command, word in _WORDS.items())
            return Answer(False, f"{request.command} is no command here; there are {known}.")
        if request.until_us and now_us() > request.until_us:
            return Answer(False, "The command came too late and was not executed.")
        if request.until_us > now_us() + round(COMMAND_VALID_S * 1e6):
            why = f"The command was not executed: until_us is more than {COMMAND_VALID_S:g} s ahead. Check the clock."
            return Answer(False, why)
        return self.program.command(_WORDS[request.command])

    def _close(self) -> None:
        self.program.close("sigterm")
        with self._lock:
            if self._last is not None:
                self._publish(replace(self._last, state=EndEffectorState.OFF, count=self._count + 1))

    def _health(self) -> Health:
        status = self.program.status
        bad = not status.link_up or status.ee in _ERRORS
        level = ERROR if bad else WARN if standing(status.alarms) or status.missed else OK
        late = f"{status.missed} edges were taken later than the reaction bound." if status.missed else ""
        return Health(
            level,
            " ".join((*status.alarm_texts, late)).strip() or "As it should be.",
            {
                "link up": status.link_up,
                "stale channels": ", ".join(status.stale) or "none",
                "edges later than the reaction bound": status.missed,
                "sensor frames refused": status.refused_frames,
                "worst lateness (ms)": f"{status.worst_late_us / 1000:.3f}",
                "reason": status.reason,
            },
        )
