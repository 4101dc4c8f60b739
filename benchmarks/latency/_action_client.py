"""A program: an application on ROS, with an action client and a subscription; commands as `_tool_client`."""

from __future__ import annotations

import json
import random
import sys
import threading
import time
from pathlib import Path
from typing import Any

import actionlib
import rospy
from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal, EndEffectorState, Outcome, State

from end_effector_hal.wires import now_us

ACTIONS = {"grip": "TriggerGrip", "drop": "Drop"}
LONGEST_S, LOST_S = 70.0, 10.0


def main(notes: str) -> None:
    rospy.init_node("bench_client", disable_signals=True)
    taken: list[dict[str, object]] = []
    stand_by, lost = threading.Event(), threading.Event()

    def listen(state: Any) -> None:
        received = now_us()
        taken.append(
            {"received": received, "at": state.at_us, "ee": state.state, "outputs": list(state.outputs)}
        )
        if state.state == State.GRIP_ERROR:
            lost.set()
        if state.state == 6:
            stand_by.set()

    rospy.Subscriber("EndEffectorState", EndEffectorState, listen, queue_size=100, tcp_nodelay=True)
    clients = {name: actionlib.ActionClient(action, EndEffectorAction) for name, action in ACTIONS.items()}
    for client in clients.values():
        client.wait_for_server()
    stand_by.wait()

    def give(name: str) -> None:
        ended = threading.Event()

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE:
                ended.set()

        time.sleep(random.uniform(0.05, 0.1))  # at any phase of the frames
        taken.append({"goal": name, "at": now_us()})
        handle = clients[name].send_goal(EndEffectorGoal(), transition_cb=moved)
        result = handle.get_result() if ended.wait(LONGEST_S) else None
        if result is None or result.outcome != Outcome.SUCCEEDED:
            print(f"failed: {name}. {result.reason if result else 'It does not end.'}", flush=True)
            time.sleep(1.0)
            ended.clear()
            handle = clients["drop"].send_goal(EndEffectorGoal(), transition_cb=moved)
            ended.wait(LONGEST_S)

    def lose(count: int) -> None:
        for _ in range(count):
            lost.clear()
            give("grip")
            if not lost.wait(LOST_S):
                print("failed: nothing was lost.", flush=True)
            give("drop")

    print("ready", flush=True)
    for line in sys.stdin:
        word, *rest = line.split()
        if word == "lose":
            lose(int(rest[0]))
            word = ""
        for name in ["grip", "drop"] * int(rest[0]) if word == "cycles" else word.split():
            give(name)
        time.sleep(0.2)
        with Path(notes).open("a", encoding="utf-8") as file:
            written, taken[:] = taken[:], []
            file.writelines(json.dumps(note) + "\n" for note in written)
        print("done", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
