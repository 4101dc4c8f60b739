"""``/diagnostics`` at 1 Hz, for people (REP-107): never a keep-alive, nothing decides by it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from end_effector_hal.nodes.interface import DIAGNOSTICS, DIAGNOSTICS_HZ
from end_effector_hal.nodes.transport import (
    DiagnosticMessage,
    DiagnosticsMessage,
    KeyValueMessage,
    NodeTransport,
)

OK, WARN, ERROR = 0, 1, 2
"""The levels of ``diagnostic_msgs/DiagnosticStatus``."""


@dataclass(frozen=True, slots=True)
class Health:
    """The health of a node: a level, a sentence, and values by their names."""

    level: int
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


def publish_health(node: NodeTransport, hardware: str, health: Callable[[], Health]) -> None:
    """Publish the health of a node every second."""
    publish = node.publisher(DIAGNOSTICS)

    def tick() -> None:
        now, unknown = health(), node.unknown_senders.alarms()
        level = max(now.level, WARN) if unknown else now.level
        counts = {f"dropped, {what}": count for what, count in node.unknown_senders.counts().items()}
        values = [KeyValueMessage(key, str(value)) for key, value in {**now.values, **counts}.items()]
        # the sentence of the health may contain an alarm already
        new = [alarm for alarm in unknown if alarm not in now.message]
        message = " ".join((*new, now.message))
        publish(DiagnosticsMessage([DiagnosticMessage(level, node.name, message, hardware, values)]))

    node.every(DIAGNOSTICS_HZ, tick)
