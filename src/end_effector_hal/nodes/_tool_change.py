"""Node ToolChange: the commands of the tool changer, which the node Grip executes."""

from __future__ import annotations

import threading
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import CHANNELS, Outcome, judge
from end_effector_hal.vocabulary import ChangerState, Command
from end_effector_hal.wires import now_us

from ._silence import Silence
from .interface import ARM, ARM_TOOL_CHANGER, GRIP_COMMAND, GRIP_STATE, set_tool_changer
from .report import ERROR, OK, WARN, Health, log_refusal, publish_health
from .transport import NodeTransport, StampCheck, StatusMessage, status_from_message

MARGIN_S = 1.0
"""Additional wait for the end of a command, s; then the caller gets an answer in any case."""
NO_END = "The node Grip has not reported how the command ended. Read the state before the next command."


class ToolChangeNode:
    """Asks Grip for the commands of the tool changer, and reads from its states how they end."""

    def __init__(self, node: NodeTransport) -> None:
        description = node.description()
        self._log = node.log
        self._stamps, self._silence = StampCheck("Internal states", node.log), Silence()
        self._news = threading.Condition()
        self._status = StatusMessage()
        self._grip = node.command_client(GRIP_COMMAND)
        node.subscribe(GRIP_STATE, self._on_status)
        publish_health(node, description.name, self._health)
        changer, service = description.tool_changer, set_tool_changer(description)
        if changer is not None and service is not None:
            self._longest_s = changer.prove_s + MARGIN_S
            node.serve(service, self._on_set)
            node.serve(ARM_TOOL_CHANGER, self._on_arm)

    def _on_status(self, status: StatusMessage) -> None:
        with self._news:
            if self._stamps.accepts(status.since_us, status.at_us):
                self._silence.reported(now_us())
                self._status = status
                self._news.notify_all()

    def _on_arm(self, _request: Any) -> Answer:
        return self._logged("arm", self._grip.ask(ARM))

    def _on_set(self, request: Any) -> Answer:
        command = Command.UNLOCK if request.data else Command.LOCK
        wanted = ChangerState.UNLOCKED if request.data else ChangerState.LOCKED
        return self._logged(CHANNELS[command], self._change(command, wanted))

    def _logged(self, what: str, answer: Answer) -> Answer:
        if not answer.accepted:
            log_refusal(self._log, what, answer)
        return answer

    def _change(self, command: Command, wanted: ChangerState) -> Answer:
        before = self._status
        if self._silence.lasts(now_us()):
            return Answer(False, str(self._silence.alarm), decided=False)
        if before.tool_changer == wanted:
            return Answer(True, f"The tool changer is {wanted.name} already, proven by its sensors.")
        answer = self._grip.ask(command)
        if not answer.accepted:
            return answer

        def is_over() -> bool:
            now = self._status
            follows = now.since_us == before.since_us and now.count >= answer.count
            return follows and now.command == Command.NONE

        with self._news:
            if not self._news.wait_for(is_over, self._longest_s):
                return Answer(False, NO_END, decided=False)
            outcome, why = judge(command, status_from_message(self._status))
        if outcome is Outcome.SUCCEEDED:
            return Answer(True, f"The tool changer is {wanted.name}, proven by its sensors.")
        return Answer(False, why, decided=outcome is not Outcome.UNREACHABLE)

    def _health(self) -> Health:
        if self._silence.lasts(now_us()):
            return Health(ERROR if self._silence.has_reported else WARN, str(self._silence.alarm))
        changer = ChangerState(self._status.tool_changer)
        return Health(
            ERROR if changer is ChangerState.FAULT else OK,
            self._status.changer_reason or "As it should be.",
            {"tool changer": changer.name, "unlock output": bool(self._status.unlock_output)},
        )
