"""Reports of the nodes for people: ``/diagnostics`` at 1 Hz (REP-107), and the log line about a refused command.

They are no keep-alive, and no program decides by them.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from end_effector_hal.control import Answer, Status, refused, unanswered
from end_effector_hal.runtime import Tool
from end_effector_hal.vocabulary import EndEffectorState

from .interface import DIAGNOSTICS, DIAGNOSTICS_HZ
from .transport import DiagnosticMessage, DiagnosticsMessage, KeyValueMessage, NodeTransport

OK, WARN, ERROR = 0, 1, 2
"""The levels of ``diagnostic_msgs/DiagnosticStatus``."""
_ERRORS = (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


@dataclass(frozen=True, slots=True)
class Health:
    """The health of a node: a level, a sentence, and values by their names."""

    level: int
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


def level_of(status: Status) -> int:
    """Return the level of a tool: ERROR without readings or in an error, WARN with an alarm or after a late reaction.

    An alarm that is over and waits for an acknowledgement does not count.
    """
    if not status.link_up or status.ee in _ERRORS:
        return ERROR
    return WARN if status.missed or any(not alarm.over for alarm in status.alarms) else OK


def silence(tool: Tool) -> Health | None:
    """Return the health of a node that cannot reach the HAL; None: it can."""
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


def logged(log: logging.Logger, what: str, answer: Answer) -> Answer:
    """Return the answer; log one line if the command was refused, or not answered in time."""
    if not answer.accepted:
        said = refused if answer.decided else unanswered
        log.info("%s", said(what, answer.reason))
    return answer
