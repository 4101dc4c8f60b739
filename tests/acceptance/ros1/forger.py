"""A node that claims what is not so: ``frames``, ``status`` or ``server``, under its ``own`` name or a ``claimed`` one.

With a claimed name it writes that of the true publisher into its connections, and is registered under its own.
"""

from __future__ import annotations

import sys
import threading
import time

import rospy
from end_effector_msgs.msg import SensorFrame, UnitStatus
from end_effector_msgs.srv import HalCommand, HalCommandResponse

GRIPPED, CONFIRMED = 3, 3


def frame(number: int) -> SensorFrame:
    values = {
        "bottom": -78_000, "cylinder": 598_000, "top": -78_000, "supply": 600_000, "locked": 1, "unlocked": 0,
        "tool_present": 1, "in_stand": 1, "cylinder_extended": 1, "cylinder_retracted": 0, "estop_ok": 1,
    }  # fmt: skip
    noise = {"bottom": number % 7, "cylinder": number % 5, "top": number % 3, "supply": number % 11}
    return SensorFrame(
        at_us=time.monotonic_ns() // 1000,
        seq=number % 65536,
        device_ms=number * 4,
        channels=list(values),
        values=[value + noise.get(name, 0) for name, value in values.items()],
        valid=[True] * len(values),
    )


def status(number: int) -> UnitStatus:
    return UnitStatus(
        since_us=1, count=number, at_us=time.monotonic_ns() // 1000, state=GRIPPED, command=-1, actuators=[2, 2, 2],
        outputs=[True] * 3, evidence=[CONFIRMED] * 3, step=-1, deadline_us=-1, cause_at=-1, held=True,
        lift_allowed=True, secure=True, link_up=True,
    )  # fmt: skip


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main(what: str, claim: str) -> None:
    rospy.init_node("forger", disable_signals=True)
    if what == "server":
        rospy.Service("grip/command", HalCommand, lambda _: HalCommandResponse(accepted=True))
        say("forging")
        threading.Event().wait()
    topic, kind, make, owner = {
        "frames": ("sensor_frame", SensorFrame, frame, "/Pressure"),
        "status": ("grip/state", UnitStatus, status, "/Grip"),
    }[what]
    headers = {"callerid": owner} if claim == "claimed" else None
    publisher = rospy.Publisher(topic, kind, queue_size=10, headers=headers)
    for number in range(1, sys.maxsize):
        publisher.publish(make(number))
        if number == 1:
            say("forging")
        time.sleep(0.004)


if __name__ == "__main__":
    main(*sys.argv[1:])
