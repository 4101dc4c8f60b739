"""The client in ROS 1."""

from __future__ import annotations

from typing import Any

import actionlib
import rospy
from end_effector_msgs.msg import (
    EndEffectorAction,
    EndEffectorGoal,
    EndEffectorState,
    ToolChangerPosition,
)
from sensor_msgs.msg import FluidPressure

from tests.acceptance.kill_matrix.client import ACTIONS, HEARD, Client

SUCCEEDED = 3
TYPES = {"PressureSupply": FluidPressure, "PositionToolChanger": ToolChangerPosition}


class Ros1Client(Client):
    def __init__(self) -> None:
        super().__init__()
        self._goals: list[Any] = []
        rospy.Subscriber("EndEffectorState", EndEffectorState, self.state_came, tcp_nodelay=True)
        for topic, node in HEARD.items():
            rospy.Subscriber(topic, TYPES[topic], self.came, node, tcp_nodelay=True)
        self._clients = {
            name: actionlib.ActionClient(action, EndEffectorAction) for name, action in ACTIONS.items()
        }

    def send(self, number: int, name: str) -> None:
        client = self._clients[name]
        client.wait_for_server(rospy.Duration(10))

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE:
                succeeded = handle.get_goal_status() == SUCCEEDED
                self.ended(number, name, handle.get_result(), succeeded=succeeded)

        self._goals.append(client.send_goal(EndEffectorGoal(), moved))


rospy.init_node("kill_matrix", anonymous=True, disable_signals=True)
Ros1Client().run()
