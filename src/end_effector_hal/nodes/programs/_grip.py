"""Node Grip: the gripping automata and their detectors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.nodes.interface import (
    GRIP_COMMAND,
    GRIP_STATE,
    RESET,
    RESET_FAULTS,
    STOP_TOOL,
    TOOL_CHANGE_COMMAND,
    TOOL_CHANGE_STATE,
    output_services,
    set_services,
)
from end_effector_hal.nodes.transport import NodeTransport, StampCheck, StatusMessage
from end_effector_hal.runtime import GripProgram, PlainOutputs, reset, stop
from end_effector_hal.vocabulary import ChangerState

from ._program_node import ProgramNode


class GripNode:
    """Runs the gripping program, which gets the state of the tool changer; serves actuators, outputs, stop, reset."""

    def __init__(self, node: NodeTransport) -> None:
        self._description = node.description()
        self._node = ProgramNode(node, self._description, GripProgram, GRIP_STATE, GRIP_COMMAND)
        self._program = self._node.program
        self._told: dict[str, int] = {}
        self._stamps = StampCheck("States of ToolChange", node.log)
        fitted = self._description.tool_changer is not None
        self._changer = node.command_client(TOOL_CHANGE_COMMAND) if fitted else None
        node.subscribe(TOOL_CHANGE_STATE, self._on_tool_change)
        self._outputs = PlainOutputs(self._description)
        node.on_close(self._outputs.close)
        for name, service in set_services(self._description).items():
            node.serve(service, self._setter(name, self._program.set_actuator))
        for name, service in output_services(self._description).items():
            node.serve(service, self._setter(name, self._outputs.set))
        node.serve(STOP_TOOL, self._stop)
        node.serve(RESET_FAULTS, self._reset)

    def _stop(self, _request: Any) -> Answer:
        answer = stop(self._description)
        if not answer.accepted:
            self._node.log_refusal("stop", answer)
        return answer

    def _reset(self, _request: Any) -> Answer:
        changer = [self._changer.ask(RESET)] if self._changer else []  # first: see EndEffector.reset
        answer = reset(self._description, self._program, *changer)
        if not answer.accepted:
            self._node.log_refusal("reset", answer)
        return answer

    def _on_tool_change(self, message: StatusMessage) -> None:
        accepted = self._stamps.accepts(message.since_us, message.at_us)
        told = {
            "unlock_valve": int(message.unlock_output),
            "loose": int(message.unlock_output or message.tool_changer == ChangerState.FAULT),
        }
        if accepted and told != self._told:
            self._told = told
            self._program.update_peer(**told)

    def _setter(self, name: str, switch: Callable[[str, bool], Answer]) -> Callable[[Any], Answer]:
        def answer(request: Any) -> Answer:
            done = switch(name, bool(request.data))
            if not done.accepted:
                self._node.log_refusal(f"{name} {'on' if request.data else 'off'}", done)
            return done

        return answer
