"""The floor's application on ROS 2: sends goals (``run SECONDS``), and notes them and received states."""

from __future__ import annotations

import sys
import threading

import rclpy
from end_effector_msgs.action import EndEffector
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String
from unique_identifier_msgs.msg import UUID
from wire import Notes, give_goals, now_us


def main(path: str) -> None:
    rclpy.init()
    node, notes = rclpy.create_node("floor_client"), Notes(path)

    def received(message: String) -> None:
        notes.add(received=now_us(), state=message.data)

    node.create_subscription(String, "floor/state", received, 100)
    client = ActionClient(node, EndEffector, "floor/goal")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    client.wait_for_server()

    def give(number: int) -> None:
        def send() -> None:
            # its number is the id of the goal, which has no fields
            name = UUID(uuid=list(number.to_bytes(16, "big")))
            sent = client.send_goal_async(EndEffector.Goal(), goal_uuid=name)
            sent.add_done_callback(lambda future: future.result().get_result_async())

        # in the executor's thread: an answer that overtakes the note of its question is dropped by rclpy
        executor.create_task(send)

    give_goals(notes, give)


if __name__ == "__main__":
    main(*sys.argv[1:])
