"""Node Grip: the gripping automata and their detectors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from std_srvs.srv import SetBoolResponse, TriggerResponse

from end_effector_hal.description import Description
from end_effector_hal.runtime import reset

from ._commander import Commander
from ._node import Node
from ._stamped import Stamped
from ._table import (
    GRIP,
    GRIP_COMMAND,
    GRIP_STATE,
    RESET,
    RESET_FAULTS,
    TOOL_CHANGE_COMMAND,
    TOOL_CHANGE_STATE,
    set_services,
)
from ._unit_node import UnitNode


class GripNode:
    """One unit, the three services of its actuators, the reset, and what the tool changer says."""

    def __init__(self, node: Node, description: Description) -> None:
        self._node = UnitNode(node, description, "grip", GRIP_STATE, GRIP_COMMAND)
        self._unit = self._node.unit
        self._unlock: bool | None = None
        self._stamped = Stamped("States of ToolChange", node.log)
        self._changer = Commander(TOOL_CHANGE_COMMAND) if description.tool_changer else None
        node.subscribe(TOOL_CHANGE_STATE, self._on_tool_change)
        for name, service in set_services(description).items():
            node.serve(service, self._setter(name))

        node.serve(RESET_FAULTS, lambda _: self._reset(description))

    def _reset(self, description: Description) -> Any:
        changer = self._changer.ask(RESET) if self._changer else None  # first: see EndEffector.reset
        answer = reset(description, self._unit)
        stays = [] if answer.accepted else [answer.reason]
        stays += [] if changer is None or changer.accepted else [changer.reason]
        if not stays:
            return TriggerResponse(True, answer.reason)
        self._node.log_refusal("reset", " ".join(stays))
        return TriggerResponse(False, " ".join(stays))

    def _on_tool_change(self, message: Any) -> None:
        counts = self._stamped.counts(message.since_us, message.at_us)
        if counts and message.unlock_output != self._unlock:
            self._unlock = message.unlock_output
            self._unit.tell(unlock_valve=int(message.unlock_output))

    def _setter(self, name: str) -> Callable[[Any], Any]:
        def answer(request: Any) -> Any:
            done = self._unit.set_actuator(name, bool(request.data))
            if not done.accepted:
                self._node.log_refusal(f"{name} {'on' if request.data else 'off'}", done.reason)
            return SetBoolResponse(done.accepted, done.reason)

        return answer


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(GRIP, argv)
    GripNode(node, node.description())
    return node.spin()
