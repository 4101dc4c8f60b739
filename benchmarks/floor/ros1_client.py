"""The floor's application: sends goals (``run SECONDS``), and notes them and the times of received states."""

from __future__ import annotations

import sys
import time

import rospy
from std_msgs.msg import String, UInt64
from wire import Notes, give_goals, now_us


def main(path: str) -> None:
    rospy.init_node("floor_client", disable_signals=True)
    notes = Notes(path)

    def received(message: String) -> None:
        notes.add(received=now_us(), state=message.data)

    rospy.Subscriber("floor/state", String, received, queue_size=100, tcp_nodelay=True)
    goals = rospy.Publisher("floor/goal", UInt64, tcp_nodelay=True, queue_size=10)
    while not goals.get_num_connections():
        time.sleep(0.05)
    give_goals(notes, goals.publish)


if __name__ == "__main__":
    main(*sys.argv[1:])
