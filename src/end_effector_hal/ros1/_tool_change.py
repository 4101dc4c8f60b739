"""Node ToolChange: the automaton of the tool changer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from std_srvs.srv import SetBoolResponse, TriggerResponse

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import ChangerState, Command

from ._node import Node
from ._stamped import Stamped
from ._table import (
    ARM_TOOL_CHANGER,
    GRIP_STATE,
    TOOL_CHANGE,
    TOOL_CHANGE_COMMAND,
    TOOL_CHANGE_STATE,
    set_tool_changer,
)
from ._unit_node import UnitNode

MARGIN_S = 1.0
"""A unit decides by itself in time; past this the caller gets an answer all the same."""


class ToolChangeNode:
    """One unit, its service, and what the gripping automata say."""

    def __init__(self, node: Node, description: Description) -> None:
        self._node = UnitNode(node, description, "tool_change", TOOL_CHANGE_STATE, TOOL_CHANGE_COMMAND)
        self._unit = self._node.unit
        self._changer = description.tool_changer
        self._ee: int | None = None
        self._stamped = Stamped("States of Grip", node.log)
        node.subscribe(GRIP_STATE, self._on_grip)
        service = set_tool_changer(description)
        if service is not None:
            node.serve(service, self._on_set)
            node.serve(ARM_TOOL_CHANGER, self._on_arm)

    def _on_grip(self, message: Any) -> None:
        if self._stamped.counts(message.since_us, message.at_us) and message.state != self._ee:
            self._ee = message.state
            self._unit.tell(ee=message.state)

    def _on_arm(self, _request: Any) -> Any:
        answer = self._unit.command("arm")
        if not answer.accepted:
            self._node.log_refusal("arm", answer.reason)
        return TriggerResponse(answer.accepted, answer.reason)

    def _on_set(self, request: Any) -> Any:
        wanted = ChangerState.UNLOCKED if request.data else ChangerState.LOCKED
        if self._unit.status.changer == wanted:
            return SetBoolResponse(True, f"The tool changer is {wanted.name} already, proven by its sensors.")
        answer = self._unit.command("unlock" if request.data else "lock")
        if not answer.accepted:
            self._node.log_refusal("unlock" if request.data else "lock", answer.reason)
            return SetBoolResponse(False, answer.reason)
        limit_s = (self._changer.prove_s if self._changer else 0.0) + MARGIN_S
        self._unit.wait(lambda status: status.command == Command.NONE, limit_s)
        reached = ChangerState(self._unit.status.changer)
        if reached is wanted:
            return SetBoolResponse(True, f"The tool changer is {wanted.name}, proven by its sensors.")
        why = f"The tool changer is {reached.name}: its sensors do not prove {wanted.name}."
        why = f"{why} {self._unit.status.reason}".rstrip()
        self._node.log_refusal("unlock" if request.data else "lock", why)
        return SetBoolResponse(False, why)


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(TOOL_CHANGE, argv)
    ToolChangeNode(node, node.description())
    return node.spin()
