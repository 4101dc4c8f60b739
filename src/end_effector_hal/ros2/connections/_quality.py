"""Quality of service, from the table."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from end_effector_hal.nodes.interface import Topic


def writer_quality(topic: Topic) -> QoSProfile:
    """Of a publisher: reliable, so that it serves every subscriber; a latched topic keeps the last message only.

    A late subscriber of a deeper one would get the last of its messages one after the other, and see the oldest first.
    """
    return _quality(topic, 1 if topic.latched else topic.queue)


def reader_quality(topic: Topic) -> QoSProfile:
    """Of a subscriber of this package."""
    return _quality(topic, topic.queue)


def _quality(topic: Topic, depth: int) -> QoSProfile:
    durability = DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=durability,
    )
