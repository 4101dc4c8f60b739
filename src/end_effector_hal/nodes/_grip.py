"""Node Grip: the services for the actuators, the plain outputs, resume, stop and reset."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from end_effector_hal.control import Answer

from .interface import RESET_FAULTS, RESUME_GRIP, STOP_TOOL, output_services, set_services
from .report import Health, level_of, logged, publish_health, silence
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
