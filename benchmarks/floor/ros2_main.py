"""The floor's node HALMain on ROS 2: forwards a goal as a service call, and publishes the unit's state."""

from __future__ import annotations

import rclpy
from end_effector_msgs.action import EndEffector
from end_effector_msgs.srv import HalCommand
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from std_msgs.msg import String


def main() -> None:
    rclpy.init()
    node, group = rclpy.create_node("floor_main"), ReentrantCallbackGroup()
    publisher = node.create_publisher(String, "floor/state", 100)
    command = node.create_client(HalCommand, "floor/command", callback_group=group)
    command.wait_for_service()

    async def execute(goal: ServerGoalHandle) -> EndEffector.Result:
        number = int.from_bytes(bytes(goal.goal_id.uuid), "big")
        await command.call_async(HalCommand.Request(until_us=number))
        goal.succeed()
        return EndEffector.Result()

    server = ActionServer(node, EndEffector, "floor/goal", execute, callback_group=group)
    node.create_subscription(String, "floor/unit_state", publisher.publish, 100)
    rclpy.spin(node)
    server.destroy()


if __name__ == "__main__":
    main()
