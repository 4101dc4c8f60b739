"""Node ToolChange: the automaton of the tool changer."""

from __future__ import annotations

from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import CHANNELS, Outcome, is_over, judge
from end_effector_hal.nodes.interface import (
    ARM_TOOL_CHANGER,
    GRIP_STATE,
    TOOL_CHANGE_COMMAND,
    TOOL_CHANGE_STATE,
    set_tool_changer,
)
from end_effector_hal.nodes.transport import NodeTransport, StampCheck, StatusMessage
from end_effector_hal.runtime import ChangerProgram
from end_effector_hal.vocabulary import ChangerState, Command

from ._program_node import ProgramNode

MARGIN_S = 1.0
"""Additional wait for the program's decision, s; then the caller gets an answer in any case."""


class ToolChangeNode:
    """Runs the program of the tool changer, which gets the state of the gripping automata; serves its commands."""

    def __init__(self, node: NodeTransport) -> None:
        description = node.description()
        self._node = ProgramNode(node, description, ChangerProgram, TOOL_CHANGE_STATE, TOOL_CHANGE_COMMAND)
        self._program = self._node.program
        self._changer = description.tool_changer
        self._ee: int | None = None
        self._stamps = StampCheck("States of Grip", node.log)
        node.subscribe(GRIP_STATE, self._on_grip)
        service = set_tool_changer(description)
        if service is not None:
            node.serve(service, self._on_set)
            node.serve(ARM_TOOL_CHANGER, self._on_arm)

    def _on_grip(self, message: StatusMessage) -> None:
        if self._stamps.accepts(message.since_us, message.at_us) and message.state != self._ee:
            self._ee = message.state
            self._program.update_peer(ee=message.state)

    def _on_arm(self, _request: Any) -> Answer:
        answer = self._program.command("arm")
        if not answer.accepted:
            self._node.log_refusal("arm", answer)
        return answer

    def _on_set(self, request: Any) -> Answer:
        wanted = ChangerState.UNLOCKED if request.data else ChangerState.LOCKED
        if self._program.status.changer == wanted:
            return Answer(True, f"The tool changer is {wanted.name} already, proven by its sensors.")
        command = Command.UNLOCK if request.data else Command.LOCK
        answer = self._program.command(CHANNELS[command])
        if answer.accepted:
            limit_s = (self._changer.prove_s if self._changer else 0.0) + MARGIN_S
            self._program.wait(is_over, limit_s)
            outcome, why = judge(command, self._program.status)
            if outcome is Outcome.SUCCEEDED:
                return Answer(True, f"The tool changer is {wanted.name}, proven by its sensors.")
            answer = Answer(False, why, decided=outcome is not Outcome.UNREACHABLE)
        self._node.log_refusal(CHANNELS[command], answer)
        return answer
