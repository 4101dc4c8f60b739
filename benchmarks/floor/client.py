"""The floor's application: gives goals, receives states.

``run SECONDS``: five goals a second, at random phases. Notes: goals, and when a state was received.
"""

from __future__ import annotations

import json
import random
import sys
import time

import rospy
from std_msgs.msg import String, UInt64
from wire import LAST_US, now_us, obey, rest_until


def main(notes: str) -> None:
    rospy.init_node("floor_client", disable_signals=True)
    taken: list[dict[str, object]] = []

    def received(message: String) -> None:
        taken.append({"received": now_us(), "state": message.data})

    rospy.Subscriber("floor/state", String, received, queue_size=100, tcp_nodelay=True)
    goals = rospy.Publisher("floor/goal", UInt64, tcp_nodelay=True, queue_size=10)
    while not goals.get_num_connections():
        time.sleep(0.05)
    count = 0

    def run(words: list[str]) -> None:
        nonlocal count
        end = now_us() + round(float(words[1]) * 1e6)
        while now_us() + 300_000 < end:
            time.sleep(random.uniform(0.1, 0.3))
            count += 1
            at = now_us()
            goals.publish(count)
            taken.append({"goal": f"c{count}", "at": at})
        rest_until(end + LAST_US)
        with open(notes, "a", encoding="utf-8") as file:
            file.writelines(json.dumps(note) + "\n" for note in taken)
        taken.clear()

    obey(run)


if __name__ == "__main__":
    main(*sys.argv[1:])
