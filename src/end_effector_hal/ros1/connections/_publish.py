"""Publishes the messages of a node on a topic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy

from end_effector_hal.nodes.interface import Topic

from ._encodable import encodable
from ._messages import MessageMaker
from ._types import message_class


def publisher(topic: Topic, is_ending: Callable[[], bool]) -> Callable[[Any], None]:
    """A function that publishes a message on a topic.

    Args:
        topic: of the table.
        is_ending: whether the node is at its end; what is published then may be lost without an error.
    """
    kind = message_class(topic.type)
    make = MessageMaker(kind)
    sender = rospy.Publisher(topic.name, kind, tcp_nodelay=True, latch=topic.latched, queue_size=topic.queue)

    def publish(message: Any) -> None:
        made = make(message)
        try:
            try:
                sender.publish(made)
            except UnicodeEncodeError:  # a text from outside, such as a third party's codec
                sender.publish(encodable(made))
        except rospy.ROSException:
            if not is_ending():
                raise

    return publish
