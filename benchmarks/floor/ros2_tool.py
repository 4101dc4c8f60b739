"""The floor of the HAL in one process on ROS 2: goals and states use ROS, the pty and the Unix socket do not."""

from __future__ import annotations

import sys
import threading

import rclpy
from end_effector_msgs.action import EndEffector
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from std_msgs.msg import String
from wire import GO, Arbiter, read_frames, word_of


def main(port: str, socket: str) -> None:
    rclpy.init()
    node, arbiter = rclpy.create_node("floor_tool"), Arbiter(socket)
    publisher = node.create_publisher(String, "floor/state", 100)

    def ask(word: bytes) -> None:
        arbiter.ask(word)
        publisher.publish(String(data=word.decode()))

    def read() -> None:
        for frame in read_frames(port):
            if frame.startswith(GO):
                ask(word_of(frame))

    def execute(goal: ServerGoalHandle) -> EndEffector.Result:
        ask(b"c%d" % int.from_bytes(bytes(goal.goal_id.uuid), "big"))
        goal.succeed()
        return EndEffector.Result()

    server = ActionServer(node, EndEffector, "floor/goal", execute)
    threading.Thread(target=read, daemon=True).start()
    rclpy.spin(node)
    server.destroy()


if __name__ == "__main__":
    main(*sys.argv[1:])
