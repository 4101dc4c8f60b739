"""The floor of the HAL on ROS 1: goals and states use ROS, the pty and the Unix socket do not."""

from __future__ import annotations

import sys
import threading

import rospy
from std_msgs.msg import String, UInt64
from wire import GO, Arbiter, read_frames, word_of


def main(port: str, socket: str) -> None:
    rospy.init_node("floor_tool")
    arbiter = Arbiter(socket)
    publisher = rospy.Publisher("floor/state", String, tcp_nodelay=True, queue_size=100)

    def ask(word: bytes) -> None:
        arbiter.ask(word)
        publisher.publish(word.decode())

    def read() -> None:
        for frame in read_frames(port):
            if frame.startswith(GO):
                ask(word_of(frame))

    rospy.Subscriber("floor/goal", UInt64, lambda goal: ask(b"c%d" % goal.data), tcp_nodelay=True)
    threading.Thread(target=read, daemon=True).start()
    rospy.spin()


if __name__ == "__main__":
    main(*sys.argv[1:])
