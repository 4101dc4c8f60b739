"""The floor's node HALMain: forwards a goal as a service call, and publishes the unit's state."""

from __future__ import annotations

import rospy
from end_effector_msgs.srv import HalCommand
from std_msgs.msg import String, UInt64


def main() -> None:
    rospy.init_node("floor_main")
    publisher = rospy.Publisher("floor/state", String, tcp_nodelay=True, queue_size=100)
    rospy.wait_for_service("floor/command")
    command = rospy.ServiceProxy("floor/command", HalCommand, persistent=True)
    rospy.Subscriber("floor/goal", UInt64, lambda goal: command(0, goal.data), tcp_nodelay=True)
    rospy.Subscriber("floor/unit_state", String, publisher.publish, queue_size=100, tcp_nodelay=True)
    rospy.spin()


if __name__ == "__main__":
    main()
