"""A client of HALMain in a process of its own: goals as JSON lines in, what it hears as JSON lines out.

It is none of the processes that are hit, and ends with its standard input.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from typing import Any

import actionlib
import rospy
from end_effector_msgs.msg import (
    EndEffectorAction,
    EndEffectorGoal,
    EndEffectorState,
    SensorFrame,
    ToolChangerPosition,
    UnitStatus,
)

ACTIONS = {"lock": "LockToolChanger", "unlock": "UnlockToolChanger", "grip": "TriggerGrip", "drop": "Drop"}
STATE_FIELDS = ("state", "command", "actuator", "held", "lift_allowed", "tool_changer", "link_up", "at_us")
PERIOD_S = 0.05


class Client:
    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._heard: dict[str, float] = {}
        self._state: dict[str, Any] = {}
        self._goals: list[Any] = []
        rospy.Subscriber("EndEffectorState", EndEffectorState, self._state_came, tcp_nodelay=True)
        rospy.Subscriber("grip/state", UnitStatus, self._unit_came, "Grip", tcp_nodelay=True)
        rospy.Subscriber("tool_change/state", UnitStatus, self._unit_came, "ToolChange", tcp_nodelay=True)
        rospy.Subscriber("sensor_frame", SensorFrame, self._came, "Pressure", tcp_nodelay=True)
        rospy.Subscriber("PositionToolChanger", ToolChangerPosition, self._came, "Position", tcp_nodelay=True)
        self._clients = {
            name: actionlib.ActionClient(action, EndEffectorAction) for name, action in ACTIONS.items()
        }

    def run(self) -> None:
        threading.Thread(target=self._repeat, daemon=True).start()
        for line in sys.stdin:
            number, name = line.split()
            threading.Thread(target=self._send, args=(int(number), name), daemon=True).start()

    def _say(self, **fields: Any) -> None:
        with self._lock:
            sys.stdout.write(json.dumps(fields) + "\n")
            sys.stdout.flush()

    def _repeat(self) -> None:
        while True:
            time.sleep(PERIOD_S)
            self._say(heard=dict(self._heard), state=self._state)

    def _came(self, _message: Any, node: str) -> None:
        self._heard[node] = time.monotonic()

    def _unit_came(self, message: Any, node: str) -> None:
        if message.state if node == "Grip" else message.tool_changer:
            self._heard[node] = time.monotonic()  # one that has adopted

    def _state_came(self, message: Any) -> None:
        self._heard["HALMain"] = time.monotonic()
        state = {name: getattr(message, name) for name in STATE_FIELDS}
        state |= {"evidence": list(message.evidence), "outputs": list(message.outputs)}
        state |= {"alarms": list(message.alarms), "reason": message.reason}
        if {**state, "alarms": 0} != {**self._state, "alarms": 0}:
            self._say(change=state)
        self._state = state

    def _send(self, number: int, name: str) -> None:
        client = self._clients[name]
        client.wait_for_server(rospy.Duration(10))

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE:
                result = handle.get_result()
                told = {"outcome": -1, "reason": ""} if result is None else {
                    "outcome": result.outcome, "reason": result.reason,
                }  # fmt: skip
                self._say(goal=number, name=name, status=handle.get_goal_status(), **told)

        self._goals.append(client.send_goal(EndEffectorGoal(), moved))


rospy.init_node("kill_matrix", anonymous=True, disable_signals=True)
Client().run()
