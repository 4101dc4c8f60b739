"""Messages and services in ROS 1: their types, and how messages are made and published."""

from __future__ import annotations

import time
from collections.abc import Callable
from copy import copy
from functools import partial
from typing import Any

import rospy

from end_effector_hal.control import Answer
from end_effector_hal.nodes.interface import Topic
from end_effector_hal.nodes.transport import RESPONSE_FIELDS, MessageHeader, ros_class
from end_effector_hal.vocabulary import printable

_TODO = "Run ros/build.sh, then . build/catkin/devel/setup.sh"

message_class = partial(ros_class, kind="msg", todo=_TODO)
service_class = partial(ros_class, kind="srv", todo=_TODO)


class MessageMaker:
    """Makes messages of one type from objects with its fields.

    Args:
        kind: the class of the message.
    """

    def __init__(self, kind: Any) -> None:
        self._kind = kind
        made = ((name, _converter(of)) for name, of in zip(kind.__slots__, kind._slot_types, strict=True))
        self._converters = {name: convert for name, convert in made if convert is not None}

    def __call__(self, source: Any) -> Any:
        """Return a message with the fields that ``source`` has; the others keep their defaults."""
        message = self._kind()
        for name in source.__slots__:
            value, convert = getattr(source, name), self._converters.get(name)
            setattr(message, name, value if convert is None else convert(value))
        return message


def response_maker(service: Any) -> Callable[[Answer], Any]:
    """Return a function that makes the response of a service (its class) from an answer."""
    response = service._response_class
    names = [RESPONSE_FIELDS.get(name, name) for name in response.__slots__]
    return lambda answer: response(*(getattr(answer, name) for name in names))


def _converter(of: str) -> Callable[[Any], Any] | None:
    if of == "std_msgs/Header":
        kind = message_class(of)
        return lambda header: kind(stamp=_STAMPS.of(header), frame_id=header.frame_id)
    if "/" not in of:
        return None
    make = MessageMaker(message_class(of.removesuffix("[]")))
    return (lambda values: [make(each) for each in values]) if of.endswith("[]") else make


class _Stamps:
    """Gives all messages of one moment the same stamp, so that message_filters and recordings can match them."""

    def __init__(self) -> None:
        self._last: tuple[int | None, Any] = (None, None)

    def of(self, header: MessageHeader) -> Any:
        """Return the ROS time of a moment on the monotonic clock; the current time if the header has none."""
        at_us, stamp = self._last
        if header.at_us is None or header.at_us != at_us:
            stamp = _stamp(header)
            self._last = header.at_us, stamp
        return stamp


_STAMPS = _Stamps()


def _stamp(header: MessageHeader) -> Any:
    before, now, after = time.monotonic_ns(), rospy.Time.now(), time.monotonic_ns()
    if header.at_us is None or not rospy.rostime.is_wallclock():
        return now
    past = (before + after) // 2 - 1000 * header.at_us
    return now - rospy.Duration(0, max(past, 0))


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


class TopicPublisher:
    """Publishes the messages of a topic; none is made that nobody reads.

    Args:
        topic: a topic of the interface table.
        is_ending: returns whether the node is at its end; messages that are published then may be lost without an
            error.
    """

    def __init__(self, topic: Topic, is_ending: Callable[[], bool]) -> None:
        kind = message_class(topic.type)
        self._make, self._latched, self._is_ending = MessageMaker(kind), topic.latched, is_ending
        self._sender = rospy.Publisher(
            topic.name, kind, tcp_nodelay=True, latch=topic.latched, queue_size=topic.queue
        )

    def is_read(self) -> bool:
        """Return whether there is a subscriber, or the topic is latched."""
        return self._latched or self._sender.get_num_connections() > 0

    def __call__(self, message: Any) -> None:
        """Publish a message."""
        if not self.is_read():
            return
        made = self._make(message)
        try:
            try:
                self._sender.publish(made)
            except UnicodeEncodeError:  # a text from outside, such as a third party's codec
                self._sender.publish(encodable(made))
        except rospy.ROSException:
            if not self._is_ending():
                raise
