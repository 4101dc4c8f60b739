"""Records what a live subscriber hears into a bag of rosbag2 (MCAP), for there is no wheel of rosbag2.

``python -m tests.acceptance.ros2.record_bag FOLDER``; it prints the count of each state, and ends on SIGINT.
"""

from __future__ import annotations

import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import rclpy
from end_effector_msgs.msg import EndEffectorState, SupervisorCommand
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import FluidPressure

from tests.support.bags import definitions

LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TOPICS = (
    ("EndEffectorState", EndEffectorState, LATCHED),
    ("PressureVacuumBottom", FluidPressure, QoSProfile(depth=100)),
    ("supervisor_commands", SupervisorCommand, QoSProfile(depth=100)),
)


def main(folder: str) -> None:
    rclpy.init()
    node = rclpy.create_node("record_bag")
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(definitions())
    with Writer(Path(folder), version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for name, kind, quality in TOPICS:
            connection = writer.add_connection(
                f"/{name}", f"{kind.__module__.partition('.')[0]}/msg/{kind.__name__}", typestore=store
            )

            def write(data: bytes, connection: Any = connection, kind: Any = kind) -> None:
                writer.write(connection, time.time_ns(), data)
                if kind is EndEffectorState:
                    print(deserialize_message(data, kind).count, flush=True)  # noqa: T201 the test waits for it

            node.create_subscription(kind, name, write, quality, raw=True)
        with suppress(KeyboardInterrupt, ExternalShutdownException):
            rclpy.spin(node)


if __name__ == "__main__":
    main(*sys.argv[1:])
