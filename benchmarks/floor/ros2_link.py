"""The floor's node Pressure on ROS 2: publishes each frame of the port as a message."""

from __future__ import annotations

import sys

import rclpy
from std_msgs.msg import String
from wire import read_frames


def main(port: str) -> None:
    rclpy.init()
    publisher = rclpy.create_node("floor_link").create_publisher(String, "floor/frame", 50)
    for frame in read_frames(port):
        publisher.publish(String(data=frame.decode()))


if __name__ == "__main__":
    main(*sys.argv[1:])
