"""Node Grip: the services for the actuators, the plain outputs, stop and reset."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.vocabulary import EndEffectorState

from .interface import RESET_FAULTS, STOP_TOOL, output_services, set_services
from .report import ERROR, OK, WARN, Health, log_refusal, publish_health, silence, standing
from .transport import NodeTransport

_ERRORS = (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


class GripNode:
    """Passes the calls of its services to the tool."""

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._tool = node.log, node.tool()
        description = self._tool.description
        for name, service in set_services(description).items():
            node.serve(service, self._setter(name, self._tool.set_actuator))
        for name, service in output_services(description).items():
            node.serve(service, self._setter(name, self._tool.set_output))
        node.serve(STOP_TOOL, lambda _request: self._logged("stop", self._tool.stop()))
        node.serve(RESET_FAULTS, lambda _request: self._logged("reset", self._tool.reset()))
        publish_health(node, description.name, self._health)

    def _logged(self, what: str, answer: Answer) -> Answer:
        if not answer.accepted:
            log_refusal(self._log, what, answer)
        return answer

    def _setter(self, name: str, switch: Callable[[str, bool], Answer]) -> Callable[[Any], Answer]:
        def answer(request: Any) -> Answer:
            active = bool(request.data)
            return self._logged(f"{name} {'on' if active else 'off'}", switch(name, active))

        return answer

    def _health(self) -> Health:
        if silent := silence(self._tool):
            return silent
        status = self._tool.status
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
