"""A client as the tutorials of ROS 2 write it, with any rclpy: gives goals, and prints what comes of them.

It imports nothing of this product but its messages. Arguments: names of actions; ``NAME!`` is cancelled at its first
feedback.
"""

import json
import sys
import time
from typing import Any

import rclpy
import rclpy.node
from end_effector_msgs.action import EndEffector
from end_effector_msgs.msg import EndEffectorState
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile

PATIENCE_S = 60.0
SETTLE_S = 3.0
"""A cancel right after the first valve was opened: its vacuum may rise once more when the release is over (IL-07)."""


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("peer")
    states: list[str] = []
    latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(
        EndEffectorState, "EndEffectorState", lambda message: states.append(message.state_name), latched
    )
    for word in sys.argv[1:]:
        name, cancel = word.removesuffix("!"), word.endswith("!")
        client = ActionClient(node, EndEffector, name)
        if not client.wait_for_server(PATIENCE_S):
            sys.exit(f"{name} is not served")
        until = time.monotonic() + SETTLE_S
        said = give(node, client, cancel)
        while said["reason"].startswith("IL-07") and time.monotonic() < until:
            said = give(node, client, cancel)
        said |= {"action": name, "state": states[-1] if states else ""}
        sys.stdout.write(json.dumps(said) + "\n")
        sys.stdout.flush()
    node.destroy_node()
    rclpy.try_shutdown()


def give(node: rclpy.node.Node, client: ActionClient, cancel: bool) -> dict[str, Any]:
    """Give one goal; what came of it."""
    feedback: list[str] = []
    sent = client.send_goal_async(
        EndEffector.Goal(), feedback_callback=lambda message: feedback.append(message.feedback.state_name)
    )
    rclpy.spin_until_future_complete(node, sent, timeout_sec=PATIENCE_S)
    handle = sent.result()
    over = handle.get_result_async()
    while cancel and not feedback and not over.done():
        rclpy.spin_once(node, timeout_sec=1.0)
    if cancel:
        rclpy.spin_until_future_complete(node, handle.cancel_goal_async(), timeout_sec=PATIENCE_S)
    rclpy.spin_until_future_complete(node, over, timeout_sec=PATIENCE_S)
    answer = over.result()
    return {
        "status": answer.status,
        "outcome": answer.result.outcome_name,
        "reason": answer.result.reason,
        "feedback": sorted(set(feedback)),
    }


main()
