"""The nodes of services: Grip, for the actuators, the plain outputs, resume, stop and reset, and ToolChange."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import CHANNELS, Outcome
from end_effector_hal.vocabulary import ChangerState, Command

from .interface import (
    ARM_TOOL_CHANGER,
    RESET_FAULTS,
    RESUME_GRIP,
    STOP_TOOL,
    output_services,
    set_services,
    set_tool_changer,
)
from .report import ERROR, OK, Health, level_of, logged, publish_health, silence
from .transport import NodeTransport


class GripNode:
    """Passes the calls of its services to the tool."""

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._tool = node.log, node.tool()
        description = self._tool.description
        for name, service in set_services(description).items():
            node.serve(service, self._setter(name, self._tool.set_actuator))
        for name, service in output_services(description).items():
            node.serve(service, self._setter(name, self._tool.set_output))
        node.serve(RESUME_GRIP, lambda _request: logged(node.log, "resume", self._tool.resume()))
        node.serve(STOP_TOOL, lambda _request: logged(node.log, "stop", self._tool.stop()))
        node.serve(RESET_FAULTS, lambda _request: logged(node.log, "reset", self._tool.reset()))
        publish_health(node, description.name, self._health)

    def _setter(self, name: str, switch: Callable[[str, bool], Answer]) -> Callable[[Any], Answer]:
        def answer(request: Any) -> Answer:
            active = bool(request.data)
            return logged(self._log, f"{name} {'on' if active else 'off'}", switch(name, active))

        return answer

    def _health(self) -> Health:
        if silent := silence(self._tool):
            return silent
        status = self._tool.status
        late = f"{status.missed} edges were taken later than the reaction bound." if status.missed else ""
        return Health(
            level_of(status),
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


MARGIN_S = 1.0
"""Additional wait for the end of a command, s; then the caller gets an answer in any case."""
NO_END = "The HAL has not reported how the command ended. Read the state before the next command."


class ToolChangeNode:
    """Passes the commands of the tool changer to the tool, and waits for their end."""

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._tool = node.log, node.tool()
        description = self._tool.description
        changer, service = description.tool_changer, set_tool_changer(description)
        if changer is not None and service is not None:
            self._longest_s = changer.prove_s + MARGIN_S
            node.serve(service, self._on_set)
            node.serve(ARM_TOOL_CHANGER, lambda _request: logged(node.log, "arm", self._tool.arm()))
        publish_health(node, description.name, self._health)

    def _on_set(self, request: Any) -> Answer:
        command = Command.UNLOCK if request.data else Command.LOCK
        wanted = ChangerState.UNLOCKED if request.data else ChangerState.LOCKED
        return logged(self._log, CHANNELS[command], self._change(command, wanted))

    def _change(self, command: Command, wanted: ChangerState) -> Answer:
        if self._tool.status.changer is wanted:
            return Answer(True, f"The tool changer is {wanted.name} already, proven by its sensors.")
        begun = self._tool.begin(command)
        try:
            result = begun.wait(self._longest_s)
        except TimeoutError:
            return Answer(False, NO_END, decided=False)
        if result.succeeded:
            return Answer(True, f"The tool changer is {wanted.name}, proven by its sensors.")
        return Answer(False, result.reason, decided=result.outcome is not Outcome.UNREACHABLE)

    def _health(self) -> Health:
        if silent := silence(self._tool):
            return silent
        status = self._tool.status
        return Health(
            ERROR if status.changer is ChangerState.FAULT else OK,
            status.changer_reason or "As it should be.",
            {"tool changer": status.changer.name, "unlock output": status.unlock_output},
        )
