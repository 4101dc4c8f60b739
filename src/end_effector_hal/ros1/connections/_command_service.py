"""A connection to the command service of a node, in ROS 1."""

from __future__ import annotations

import rospy

from end_effector_hal.control import Answer
from end_effector_hal.nodes.interface import Service

from ._known_publishers import nodes_of
from ._messages import service_class

_NOT_REACHED = (rospy.ServiceException, rospy.ROSException, rospy.exceptions.TransportException, OSError)


class CommandService:
    """A persistent connection to the command service of a node; rospy has no time-out, so that a call may hang."""

    def __init__(self, service: Service) -> None:
        self._service = service
        try:
            self._proxy = rospy.ServiceProxy(service.name, service_class(service.type), persistent=True)
        except _NOT_REACHED:
            raise self._not_reached() from None

    def call(self, command: int, until_us: int) -> Answer:
        """Request a command, which must begin before ``until_us``; raises ConnectionError."""
        try:
            answer = self._proxy(command, until_us)
            answered = str(self._proxy.transport.header.get("callerid", ""))
        except _NOT_REACHED:
            raise self._not_reached() from None
        if answered not in nodes_of(self._service.name, (self._service.server,)):
            raise ConnectionError(f"Another node answers for {self._service.server}: {answered[:80]!a}.")
        return Answer(answer.accepted, answer.reason, answer.decided, answer.count)

    def close(self) -> None:
        """Close the connection."""
        self._proxy.close()

    def _not_reached(self) -> ConnectionError:
        return ConnectionError(f"The node {self._service.server} cannot be reached.")
