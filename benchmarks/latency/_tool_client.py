"""A program: the tool in one process, without ROS, and what its listener gets.

``cycles N``: N times grip and drop, each after a random rest. ``lose N``: the same, with a wait until what is held
is lost. ``grip`` and ``drop`` do one. What fails is said,
and dropped.
"""

from __future__ import annotations

import json
import random
import sys
import threading
import time
from pathlib import Path

from end_effector_hal.control import Status
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import be_steady, now_us

LOST_S = 10.0


def main(description: str, notes: str) -> None:
    taken: list[dict[str, object]] = []
    lost = threading.Event()

    def listen(status: Status) -> None:
        received = now_us()
        taken.append(
            {"received": received, "at": status.at, "ee": status.ee, "outputs": list(status.outputs)}
        )
        if status.ee == EndEffectorState.GRIP_ERROR:
            lost.set()

    def give(name: str) -> None:
        time.sleep(random.uniform(0.05, 0.1))  # at any phase of the frames
        taken.append({"goal": name, "at": now_us()})
        outcome = tool.grip() if name == "grip" else tool.drop()
        if not outcome.succeeded:
            print(f"failed: {name}, {outcome.state.name}. {outcome.reason}", flush=True)
            time.sleep(1.0)
            tool.drop()

    def lose(count: int) -> None:
        for _ in range(count):
            lost.clear()
            give("grip")
            if not lost.wait(LOST_S):
                print("failed: nothing was lost.", flush=True)
            give("drop")

    with EndEffector.open(description) as tool:
        tool.subscribe(listen)
        tool.wait_ready(10.0)
        be_steady()
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
                file.writelines(json.dumps(note) + "\n" for note in taken)
            taken.clear()
            print("done", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
