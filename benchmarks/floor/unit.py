"""The floor's node Grip: forwards pings and commands to the arbiter, then publishes a state."""

from __future__ import annotations

import sys

import rospy
from end_effector_msgs.srv import HalCommand, HalCommandResponse
from std_msgs.msg import String
from wire import GO, Arbiter, word_of


def main(socket: str) -> None:
    rospy.init_node("floor_unit")
    arbiter = Arbiter(socket)
    publisher = rospy.Publisher("floor/unit_state", String, tcp_nodelay=True, queue_size=100)

    def on_frame(message: String) -> None:
        frame = message.data.encode()
        if frame.startswith(GO):
            word = word_of(frame)
            arbiter.ask(word)
            publisher.publish(word.decode())

    def on_command(request: HalCommand) -> HalCommandResponse:
        word = f"c{request.until_us}"
        arbiter.ask(word.encode())
        publisher.publish(word)
        return HalCommandResponse(True, "", 0, True)

    rospy.Service("floor/command", HalCommand, on_command)
    rospy.Subscriber("floor/frame", String, on_frame, queue_size=50, tcp_nodelay=True)
    rospy.spin()


if __name__ == "__main__":
    main(*sys.argv[1:])
