"""``/diagnostics`` at 1 Hz, for people (REP-107): it is no keep-alive, and no program decides by it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from end_effector_hal.nodes.interface import DIAGNOSTICS, DIAGNOSTICS_HZ
from end_effector_hal.nodes.transport import (
    DiagnosticMessage,
    DiagnosticsMessage,
    KeyValueMessage,
    NodeTransport,
)
from end_effector_hal.runtime import Tool
from end_effector_hal.vocabulary import Alarm

OK, WARN, ERROR = 0, 1, 2
"""The levels of ``diagnostic_msgs/DiagnosticStatus``."""


@dataclass(frozen=True, slots=True)
class Health:
    """The health of a node: a level, a sentence, and values by their names."""

    level: int
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


def standing(alarms: Sequence[Alarm]) -> bool:
    """Return whether an alarm is active; an alarm that is over and waits for an acknowledgement does not count."""
    return any(not alarm.over for alarm in alarms)


def silence(tool: Tool) -> Health | None:
    """Return the health of a node that does not hear the HAL; None: it does."""
    if tool.alive:
        return None
    status = tool.status
    lost = status.alarm("hal.lost")
    return Health(ERROR if status.begun else WARN, str(lost) if lost else "The HAL has not reported yet.")


def publish_health(
    node: NodeTransport, tool: str, health: Callable[[], Health], *, hardware: str = ""
) -> None:
    """Publish the health of a node every second.

    Args:
        node: the node.
        tool: name of the tool; a value of each status.
        health: returns the current health.
        hardware: the hardware that the node works with; empty: the tool.
    """
    publish = node.publisher(DIAGNOSTICS)

    def tick() -> None:
        now = health()
        values = [KeyValueMessage(key, str(value)) for key, value in {"tool": tool, **now.values}.items()]
        message = DiagnosticMessage(now.level, node.name, now.message, hardware or tool, values)
        publish(DiagnosticsMessage([message]))

    node.every(DIAGNOSTICS_HZ, tick)
