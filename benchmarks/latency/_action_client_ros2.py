"""A program: an application on ROS 2, with an action client and a subscription; controlled as an `Application`."""

from __future__ import annotations

import sys
import threading
from typing import Any

import rclpy
from _application import Application
from end_effector_msgs.action import EndEffector
from end_effector_msgs.msg import EndEffectorState, Outcome, State
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor

from end_effector_hal.wires import now_us

ACTIONS = {"grip": "TriggerGrip", "drop": "Drop"}
LONGEST_S = 70.0


def main(notes: str) -> None:
    rclpy.init()
    node = rclpy.create_node("bench_client")
    application, stand_by = Application(notes), threading.Event()

    def listen(state: Any) -> None:
        application.state(now_us(), state.at_us, state.state, state.outputs)
        if state.state == State.STAND_BY:
            stand_by.set()

    node.create_subscription(EndEffectorState, "EndEffectorState", listen, 100)
    clients = {name: ActionClient(node, EndEffector, action) for name, action in ACTIONS.items()}
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    for client in clients.values():
        client.wait_for_server()
    stand_by.wait()

    def command(name: str) -> str:
        ended, results = threading.Event(), list[Any]()

        def over(future: Any) -> None:
            results.append(future.result().result)
            ended.set()

        def send() -> None:
            # in the executor's thread: an answer that overtakes the note of its question is dropped by rclpy
            asked = clients[name].send_goal_async(EndEffector.Goal())
            asked.add_done_callback(lambda future: future.result().get_result_async().add_done_callback(over))

        executor.create_task(send)
        if not ended.wait(LONGEST_S):
            return ". It does not end."
        return "" if results[0].outcome == Outcome.SUCCEEDED else f". {results[0].reason}"

    application.obey(command)


if __name__ == "__main__":
    main(*sys.argv[1:])
