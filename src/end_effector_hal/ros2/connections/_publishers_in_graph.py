"""Accept the messages of a topic only while the interface table names all nodes that publish on it.

ROS 2 does not report the sender of a message to a subscriber in Python, and without SROS 2 the names in the graph are
not checked either. A node can only read the names of all publishers of the topic. While the interface table does not
name one of them, all messages are dropped: readings become stale, held parts stay held, and an alarm gives the reason
(SAFETY.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from end_effector_hal.nodes.transport import UnknownSenders
from end_effector_hal.wires import now_us

ALL_DROPPED = "While it publishes there, all messages of this topic are ignored."
_NAMELESS = "_UNKNOWN_"
"""Part of the name that rclpy returns for a node of which only the publisher is known."""
NAMED_WITHIN_US = 2_000_000
"""Time for which messages of a nameless publisher are dropped without an alarm, µs."""


class PublishersInGraph:
    """Reads the graph again whenever the number of publishers has changed.

    Args:
        topic: resolved name of the topic.
        known: full names of the nodes.
        unknown_senders: counts the dropped messages.
        count: returns the number of publishers.
        names: returns the full names of the nodes that publish.
        clock: returns the monotonic time, µs.
    """

    def __init__(
        self,
        topic: str,
        known: frozenset[str],
        unknown_senders: UnknownSenders,
        count: Callable[[], int],
        names: Callable[[], Sequence[str]],
        clock: Callable[[], int] = now_us,
    ) -> None:
        self._topic, self._known, self._unknown = topic, known, unknown_senders
        self._count, self._names = count, names
        self._words = " and ".join(sorted(known))
        self._clock = clock
        self._looked_at, self._stranger = -1, ""
        self._nameless_since: int | None = None

    def admit(self, _message: Any) -> bool:
        """Return whether a message is accepted."""
        count = self._count()
        if count != self._looked_at or self._stranger:
            strangers = [name for name in self._names() if name not in self._known]
            self._stranger, self._looked_at = (strangers or [""])[0], count
        if not self._stranger:
            self._nameless_since = None
            return True
        if _NAMELESS in self._stranger:
            # the name of a node comes a moment after its publishers
            self._nameless_since = self._nameless_since or self._clock()
            if self._clock() - self._nameless_since < NAMED_WITHIN_US:
                return False
        self._unknown.drop(self._topic, self._stranger, self._words, ALL_DROPPED)
        return False
