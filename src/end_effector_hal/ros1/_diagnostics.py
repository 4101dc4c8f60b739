"""``/diagnostics`` at 1 Hz, for people (REP-107): never a keep-alive, nothing decides by it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ._node import Node, stamp
from ._table import DIAGNOSTICS, DIAGNOSTICS_HZ

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@dataclass(frozen=True, slots=True)
class Health:
    """What a node says of itself: a level, a sentence, and values by their names."""

    level: int
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


def diagnose(node: Node, hardware: str, health: Callable[[], Health]) -> None:
    """Publish the health of a node every second."""
    publish = node.publisher(DIAGNOSTICS)

    def tick() -> None:
        now = health()
        values = [KeyValue(key=key, value=str(value)) for key, value in now.values.items()]
        message = DiagnosticArray(
            status=[
                DiagnosticStatus(
                    level=now.level, name=node.name, message=now.message, hardware_id=hardware, values=values
                )
            ]
        )
        message.header.stamp = stamp()
        publish(message)

    node.every(DIAGNOSTICS_HZ, tick)
