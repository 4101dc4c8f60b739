"""A program: an application on ROS, with an action client and a subscription; controlled as an `Application`."""

from __future__ import annotations

import sys
import threading
from typing import Any

import actionlib
import rospy
from _application import Application
from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal, EndEffectorState, Outcome, State

from end_effector_hal.wires import now_us

ACTIONS = {"grip": "TriggerGrip", "drop": "Drop"}
LONGEST_S = 70.0


def main(notes: str) -> None:
    rospy.init_node("bench_client", disable_signals=True)
    application, stand_by = Application(notes), threading.Event()

    def listen(state: Any) -> None:
        application.state(now_us(), state.at_us, state.state, state.outputs)
        if state.state == State.STAND_BY:
            stand_by.set()

    rospy.Subscriber("EndEffectorState", EndEffectorState, listen, queue_size=100, tcp_nodelay=True)
    clients = {name: actionlib.ActionClient(action, EndEffectorAction) for name, action in ACTIONS.items()}
    for client in clients.values():
        client.wait_for_server()
    stand_by.wait()

    def command(name: str) -> str:
        ended = threading.Event()

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE:
                ended.set()

        handle = clients[name].send_goal(EndEffectorGoal(), transition_cb=moved)
        if not ended.wait(LONGEST_S):
            return ". It does not end."
        result = handle.get_result()
        return "" if result.outcome == Outcome.SUCCEEDED else f". {result.reason}"

    application.obey(command)


if __name__ == "__main__":
    main(*sys.argv[1:])
