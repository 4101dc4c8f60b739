"""Node Grip: the program of the tool, and its services for actuators, plain outputs, stop and reset."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.nodes.interface import RESET_FAULTS, STOP_TOOL, output_services, set_services
from end_effector_hal.nodes.report import log_refusal
from end_effector_hal.nodes.transport import NodeTransport
from end_effector_hal.runtime import PlainOutputs, reset_tool, stop

from ._program_node import ProgramNode


class GripNode:
    """Runs the program of the tool; serves actuators, plain outputs, stop and reset."""

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._description = node.log, node.description()
        self._program = ProgramNode(node, self._description).program
        self._outputs = PlainOutputs(self._description)
        node.on_close(self._outputs.close)
        for name, service in set_services(self._description).items():
            node.serve(service, self._setter(name, self._program.set_actuator))
        for name, service in output_services(self._description).items():
            node.serve(service, self._setter(name, self._outputs.set))
        node.serve(STOP_TOOL, lambda _request: self._logged("stop", stop(self._description)))
        node.serve(
            RESET_FAULTS,
            lambda _request: self._logged("reset", reset_tool(self._description, self._program)),
        )

    def _logged(self, what: str, answer: Answer) -> Answer:
        if not answer.accepted:
            log_refusal(self._log, what, answer)
        return answer

    def _setter(self, name: str, switch: Callable[[str, bool], Answer]) -> Callable[[Any], Answer]:
        def answer(request: Any) -> Answer:
            active = bool(request.data)
            return self._logged(f"{name} {'on' if active else 'off'}", switch(name, active))

        return answer
