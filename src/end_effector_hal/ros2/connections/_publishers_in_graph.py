"""Accepts the messages of a topic only while the table names every node that publishes there.

ROS 2 does not tell a subscriber in Python who sent a message; without SROS 2 nobody checks the names in the graph
either. What a node can see are the names of all publishers of the topic. While one is there that the table does not
name, none of the messages counts: sensors turn stale, what is held stays held, and an alarm says why (SAFETY.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from end_effector_hal.nodes.transport import UnknownSenders
from end_effector_hal.wires import now_us

ALL_DROPPED = "While it publishes there, no message of this topic counts."
_NAMELESS = "_UNKNOWN_"
"""In what rclpy calls a node of which it knows the publisher only."""
NAMED_WITHIN_US = 2_000_000
"""For so long such messages are dropped without an alarm."""


class PublishersInGraph:
    """Looks at the graph again whenever the number of publishers has changed.

    Args:
        topic: resolved.
        known: full names of the nodes.
        unknown_senders: counts what is dropped.
        count: gives the number of publishers.
        names: gives the full names of the nodes that publish.
        clock: microseconds, monotonic.
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
        """Whether a message counts."""
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
