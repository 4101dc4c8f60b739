"""The floor's node Grip on ROS 2: forwards pings of the topic and commands of the service to the arbiter."""

from __future__ import annotations

import sys

import rclpy
from end_effector_msgs.srv import HalCommand
from std_msgs.msg import String
from wire import GO, Arbiter, word_of


def main(socket: str) -> None:
    rclpy.init()
    node, arbiter = rclpy.create_node("floor_unit"), Arbiter(socket)
    publisher = node.create_publisher(String, "floor/unit_state", 100)

    def on_frame(message: String) -> None:
        frame = message.data.encode()
        if frame.startswith(GO):
            word = word_of(frame)
            arbiter.ask(word)
            publisher.publish(String(data=word.decode()))

    def on_command(request: HalCommand.Request, response: HalCommand.Response) -> HalCommand.Response:
        word = f"c{request.until_us}"
        arbiter.ask(word.encode())
        publisher.publish(String(data=word))
        return response

    node.create_service(HalCommand, "floor/command", on_command)
    node.create_subscription(String, "floor/frame", on_frame, 50)
    rclpy.spin(node)


if __name__ == "__main__":
    main(*sys.argv[1:])
