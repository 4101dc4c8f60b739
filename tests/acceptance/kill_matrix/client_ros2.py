"""The client in ROS 2."""

from __future__ import annotations

import os
import threading
from functools import partial
from typing import Any

import rclpy
from end_effector_msgs.action import EndEffector
from end_effector_msgs.msg import EndEffectorState, ToolChangerPosition
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import FluidPressure

from tests.acceptance.kill_matrix.client import ACTIONS, HEARD, Client

SUCCEEDED = 4
TYPES = {"PressureSupply": FluidPressure, "PositionToolChanger": ToolChangerPosition}


class Ros2Client(Client):
    def __init__(self, node: Any, executor: Any) -> None:
        super().__init__()
        self._executor = executor
        node.create_subscription(EndEffectorState, "EndEffectorState", self.state_came, 100)
        for topic, name in HEARD.items():
            node.create_subscription(TYPES[topic], topic, partial(self.came, node=name), 100)
        self._clients = {name: ActionClient(node, EndEffector, action) for name, action in ACTIONS.items()}

    def send(self, number: int, name: str) -> None:
        client = self._clients[name]
        client.wait_for_server(10.0)

        def answered(future: Any) -> None:
            handle = future.result()
            if not handle.accepted:
                self.ended(number, name, None, succeeded=False)
                return
            handle.get_result_async().add_done_callback(over)

        def over(future: Any) -> None:
            response = future.result()
            self.ended(number, name, response.result, succeeded=response.status == SUCCEEDED)

        def send() -> None:
            client.send_goal_async(EndEffector.Goal()).add_done_callback(answered)

        # in the executor's thread: an answer that overtakes the note of its question is dropped by rclpy
        self._executor.create_task(send)


rclpy.init()
node = rclpy.create_node(f"kill_matrix_{os.getpid()}")
executor = SingleThreadedExecutor()
executor.add_node(node)
client = Ros2Client(node, executor)
threading.Thread(target=executor.spin, daemon=True).start()
client.run()
os._exit(0)  # rclpy may hang at its end
