"""Accept messages and calls only from the nodes that the interface table names.

ROS 1 has no authentication. A node can check two properties of the sender:

- the name in the header of the connection, which the sender writes itself;
- the address that the connection was made to. The master stores the address of each node by its name, and ends a node
  when another one registers with its name. So the check detects a name that is used without being registered.

A process that registers at the master under the name of a node replaces it (SAFETY.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rosgraph
import rospy

from end_effector_hal.errors import RosError
from end_effector_hal.nodes.transport import UnknownSenders
from end_effector_hal.ros1.master import ask_master

_REMEMBERED = 8


def nodes_of(name: str, nodes: Sequence[str]) -> frozenset[str]:
    """Return the resolved names of the nodes that the interface table names for a topic or service.

    They are in its namespace: in that of this node, or in the one that a remap of ``name`` leads to. A remap of a
    node's own name is applied as well (``Pressure:=OtherPressure``).
    """
    here, place = str(rospy.get_namespace()), str(rospy.resolve_name(name))
    there = place.removesuffix(name) if place.endswith(f"/{name}") else here
    return frozenset(_node(each, here, there) for each in nodes)


def caller_of(message: Any) -> str:
    """Return the name that the sender of a message or a request states."""
    return str(message._connection_header.get("callerid", ""))


class KnownPublishers:
    """Checks whether a message comes from a node that the interface table names, and counts the others.

    Args:
        topic: resolved name of the topic.
        known: resolved names of the nodes.
        unknown_senders: counts the dropped messages.
        connections: returns rospy's connections of the topic: each has a ``header`` and an ``endpoint_id``.
        uri_of: returns the address that the master stores for a node; None: it has none.
    """

    def __init__(
        self,
        topic: str,
        known: frozenset[str],
        unknown_senders: UnknownSenders,
        connections: Callable[[], Sequence[Any]],
        uri_of: Callable[[str], str | None] = lambda name: ask_master("lookupNode", name),
    ) -> None:
        self._topic, self._known, self._unknown = topic, known, unknown_senders
        self._connections, self._uri_of = connections, uri_of
        self._words = " and ".join(sorted(known))
        # headers are compared by identity: there is one for each connection
        self._good: Any = None
        self._bad: list[Any] = []

    def admit(self, message: Any) -> bool:
        """Return whether a message is accepted."""
        header = message._connection_header
        if header is self._good:
            return True
        caller = caller_of(message)
        if caller in self._known:
            if self._is_registered(caller, header):
                self._good = header
                return True
            caller = f"another node under the name {caller}"
        self._unknown.drop(self._topic, caller, self._words)
        return False

    def _is_registered(self, caller: str, header: Any) -> bool:
        if any(header is each for each in self._bad):
            return False
        at = next((each.endpoint_id for each in self._connections() if each.header is header), None)
        try:
            registered = at is not None and at == self._uri_of(caller)
        except RosError:
            return False  # asked again with the next message
        if not registered:
            self._bad = [*self._bad[1 - _REMEMBERED :], header]
        return registered


def _node(name: str, here: str, there: str) -> str:
    resolved = str(rospy.resolve_name(name))
    remapped = resolved != rosgraph.names.ns_join(here, name)
    return resolved if remapped else str(rosgraph.names.ns_join(there, name))
