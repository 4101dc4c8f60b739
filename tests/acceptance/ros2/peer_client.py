"""A client as the tutorials of ROS 2 write it, with any rclpy: gives goals, and prints what comes of them.

It imports nothing of this product but its messages. Arguments: names of actions; ``NAME!`` is cancelled at its first
feedback.
"""

import json
import sys

import rclpy
from end_effector_msgs.action import EndEffector
from end_effector_msgs.msg import EndEffectorState
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile

PATIENCE_S = 60.0


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
        feedback: list[str] = []
        sent = client.send_goal_async(
            EndEffector.Goal(),
            feedback_callback=lambda message, told=feedback: told.append(message.feedback.state_name),
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
        said = {
            "action": name,
            "status": answer.status,
            "outcome": answer.result.outcome_name,
            "reason": answer.result.reason,
            "feedback": sorted(set(feedback)),
            "state": states[-1] if states else "",
        }
        sys.stdout.write(json.dumps(said) + "\n")
        sys.stdout.flush()
    node.destroy_node()
    rclpy.try_shutdown()


main()
