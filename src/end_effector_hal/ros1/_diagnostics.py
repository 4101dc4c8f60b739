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
        now, strangers = health(), node.strangers.alarms()
        level = max(now.level, WARN) if strangers else now.level
        counts = {f"dropped, {what}": count for what, count in node.strangers.counts().items()}
        values = [KeyValue(key=key, value=str(value)) for key, value in {**now.values, **counts}.items()]
        # the state, and what is made of it, tells them already
        new = [alarm for alarm in strangers if alarm not in now.message]
        message = DiagnosticArray(
            status=[
                DiagnosticStatus(
                    level=level,
                    name=node.name,
                    message=" ".join((*new, now.message)),
                    hardware_id=hardware,
                    values=values,
                )
            ]
        )
        message.header.stamp = stamp()
        publish(message)

    node.every(DIAGNOSTICS_HZ, tick)
