"""Takes the place of the node Pressure, by its name, and publishes frames with wrong stamps until it is ended."""

from __future__ import annotations

import sys
import time

import rospy
from end_effector_msgs.msg import SensorFrame

LISTENERS = 3
"""Grip, Position, DataLogger."""


def main(stamps: list[int]) -> None:
    """Publish; a line on standard output says that each listener was sent all of them."""
    rospy.init_node("Pressure")
    publisher = rospy.Publisher("sensor_frame", SensorFrame, tcp_nodelay=True, queue_size=50)
    names = ["bottom", "cylinder", "top", "supply"]
    rounds = 0
    while not rospy.is_shutdown():
        if publisher.get_num_connections() >= LISTENERS:
            for stamp in stamps:
                publisher.publish(
                    SensorFrame(
                        at_us=stamp, seq=-1, device_ms=-1, channels=names, values=[0] * 4, valid=[True] * 4
                    )
                )
            rounds += 1
            if rounds == 10:
                sys.stdout.write("published\n")
                sys.stdout.flush()
        time.sleep(0.02)


if __name__ == "__main__":
    main([int(each) for each in sys.argv[1:]])
