"""The floor's node Pressure: publishes each frame of the port as a message."""

from __future__ import annotations

import sys

import rospy
from std_msgs.msg import String
from wire import read_frames


def main(port: str) -> None:
    rospy.init_node("floor_link", disable_signals=True)
    publisher = rospy.Publisher("floor/frame", String, tcp_nodelay=True, queue_size=50)
    for frame in read_frames(port):
        publisher.publish(frame.decode())


if __name__ == "__main__":
    main(*sys.argv[1:])
