"""Publish the messages of a node on a topic."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any

import rospy

from end_effector_hal.nodes.interface import Topic
from end_effector_hal.vocabulary import printable

from ._messages import MessageMaker, message_class

MOST = 5_000


def encodable(value: Any) -> Any:
    """Return a copy of a message, a list or a text in which every text can be encoded as UTF-8."""
    if isinstance(value, str):
        return value if _is_utf8(value) else printable(value, MOST)
    if isinstance(value, list | tuple):
        return [encodable(each) for each in value]
    if not hasattr(value, "__slots__") or not hasattr(value, "serialize"):
        return value
    made = copy(value)
    for name in value.__slots__:
        setattr(made, name, encodable(getattr(value, name)))
    return made


def _is_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def publisher(topic: Topic, is_ending: Callable[[], bool]) -> Callable[[Any], None]:
    """Return a function that publishes a message on a topic.

    Args:
        topic: a topic of the interface table.
        is_ending: returns whether the node is at its end; messages that are published then may be lost without an
            error.
    """
    kind = message_class(topic.type)
    make = MessageMaker(kind)
    sender = rospy.Publisher(topic.name, kind, tcp_nodelay=True, latch=topic.latched, queue_size=topic.queue)

    def publish(message: Any) -> None:
        if not (topic.latched or sender.get_num_connections()):
            return
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
