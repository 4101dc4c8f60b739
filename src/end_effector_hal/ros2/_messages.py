"""Messages and services in ROS 2: their types, their quality of service, and how the messages are made."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from end_effector_hal.control import Answer
from end_effector_hal.nodes.interface import Topic
from end_effector_hal.nodes.transport import RESPONSE_FIELDS, MessageHeader, has_ros_class, ros_class
from end_effector_hal.vocabulary import printable


def writer_quality(topic: Topic) -> QoSProfile:
    """Return the quality of a publisher: reliable, for every subscriber; a latched topic keeps only the last message.

    With a deeper queue a late subscriber would receive several old messages first.
    """
    return _quality(topic, 1 if topic.latched else topic.queue)


def reader_quality(topic: Topic) -> QoSProfile:
    """Return the quality of a subscriber of this package."""
    return _quality(topic, topic.queue)


def _quality(topic: Topic, depth: int) -> QoSProfile:
    durability = DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=durability,
    )


_TODO = "Build the workspace with colcon and source its install/setup.bash; in the checkout: make ros2."

message_class = partial(ros_class, kind="msg", todo=_TODO)
service_class = partial(ros_class, kind="srv", todo=_TODO)
has_action_class = partial(has_ros_class, kind="action")
action_class = partial(ros_class, kind="action", todo=_TODO)


LONGEST_TEXT = 5_000

Convert = Callable[[Any], Any]


class RclpyMessageMaker:
    """Makes messages of one type from objects with its fields.

    Args:
        kind: the class of the message.
        clock: clock of the node, for the stamps of headers.
    """

    def __init__(self, kind: Any, clock: Clock) -> None:
        self._kind = kind
        fields = kind.get_fields_and_field_types()
        self._converters = {name: _converter(of, clock) for name, of in fields.items()}

    def __call__(self, source: Any) -> Any:
        """Return a message with the fields that ``source`` has; the others keep their defaults."""
        message = self._kind()
        for name, convert in self._converters.items():
            if (value := getattr(source, name, None)) is not None:
                setattr(message, name, convert(value))
        return message


class RclpyPublisher:
    """Publishes the messages of a topic; none is made that nobody reads.

    Args:
        node: a node of rclpy.
        topic: a topic of the interface table.
    """

    def __init__(self, node: Node, topic: Topic) -> None:
        kind = message_class(topic.type)
        self._make, self._latched = RclpyMessageMaker(kind, node.get_clock()), topic.latched
        self._sender = node.create_publisher(kind, topic.name, writer_quality(topic))

    def is_read(self) -> bool:
        """Return whether there is a subscriber, or the topic is latched, and subscribers may yet come."""
        return self._latched or self._sender.get_subscription_count() > 0

    def __call__(self, message: Any) -> None:
        """Publish a message."""
        if self.is_read():
            self._sender.publish(self._make(message))


def response_maker(service: Any) -> Callable[[Answer, Any], Any]:
    """Return a function that fills the response of a service (its class) from an answer."""
    fields = service.Response.get_fields_and_field_types()
    names = {name: RESPONSE_FIELDS.get(name, name) for name in fields}

    def fill(answer: Answer, response: Any) -> Any:
        for name, source in names.items():
            value = getattr(answer, source)
            setattr(response, name, _text(value) if isinstance(value, str) else value)
        return response

    return fill


def _converter(of: str, clock: Clock) -> Convert:
    if of.startswith("sequence<"):
        each = _converter(of.removeprefix("sequence<").removesuffix(">"), clock)
        return lambda values: [each(value) for value in values]
    if of == "std_msgs/Header":
        kind = message_class(of)
        return lambda header: kind(stamp=_STAMPS.of(header, clock), frame_id=header.frame_id)
    if "/" in of:
        return RclpyMessageMaker(message_class(of), clock)
    if of == "octet":
        return lambda value: bytes([value])
    return _PLAIN.get(of, int)


def _text(text: str) -> str:
    """Return a text that can be encoded: a text from outside, such as a third party's codec, must not end a node."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return printable(text, LONGEST_TEXT)
    return text


class _Stamps:
    """Gives all messages of one moment the same stamp, so that message_filters and recordings can match them."""

    def __init__(self) -> None:
        self._last: tuple[int | None, Time] = (None, Time())

    def of(self, header: MessageHeader, clock: Clock) -> Time:
        """Return the ROS time of a monotonic time; the current time if the header has none or time is simulated."""
        if header.at_us is None or _is_simulated(clock):
            return _time(clock.now().nanoseconds)
        at_us, stamp = self._last
        if header.at_us != at_us:
            before, now, after = time.monotonic_ns(), clock.now().nanoseconds, time.monotonic_ns()
            stamp = _time(now - max(0, (before + after) // 2 - 1000 * header.at_us))
            self._last = header.at_us, stamp
        return stamp


_STAMPS = _Stamps()


def _is_simulated(clock: Clock) -> bool:
    return clock.clock_type is ClockType.ROS_TIME and getattr(clock, "ros_time_is_active", False)


def _time(nanoseconds: int) -> Time:
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)


_PLAIN: dict[str, Convert] = {"string": _text, "double": float, "boolean": bool}
