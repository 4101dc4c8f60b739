"""HALMain's goals without a master: the tool answers what a test says."""

from __future__ import annotations

import logging
import threading
from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Phase
from end_effector_hal.vocabulary import Cause, Command, EndEffectorState
from tests.support.goal_server import Wire
from tests.support.lone_node import status
from tests.support.patience import wait_until

STATUSES = ("PREEMPTED", "SUCCEEDED", "ABORTED", "REJECTED", "RECALLED", "LOST")
STAND_BY, GRIPPED, GRIPPING = 6, 3, 1
NONE, GRIP, RELEASE = -1, 2, 3


class Tool:
    """In place of the tool: answers what a test says, or hangs until it is let go."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.replies: list[Answer] = []
        self.goes_on = threading.Event()
        self.goes_on.set()

    def command(self, name: str, part: str = "") -> Answer:
        self.asked.append(f"{name} {part}".rstrip())
        assert self.goes_on.wait(60.0)
        return self.replies.pop(0) if self.replies else Answer(True, count=7)

    def ending(self) -> str:
        return "What is held stays held."


class Hal:
    """HALMain's goals, without a master."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        import rospy
        from end_effector_msgs.msg import EndEffectorState as Message
        from end_effector_msgs.msg import StepReport

        from end_effector_hal.nodes._goal_types import CommandGoals
        from end_effector_hal.nodes._served_goals import ServedGoals
        from end_effector_hal.nodes.interface import COMMAND_ACTIONS
        from end_effector_hal.ros1._actions import GoalServer
        from end_effector_hal.ros1._later import Later

        def start(server: Any) -> None:
            server.result_pub, server.status_pub, server.feedback_pub = Wire(), Wire(), Wire()
            server.status_list_timeout, server.started = rospy.Duration(5.0), True

        monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
        monkeypatch.setattr(rospy.rostime, "_rostime_current", None)
        self.tool = Tool()
        monkeypatch.setattr(GoalServer, "start", start)
        self.state = Message(state=GRIPPING, steps=[StepReport(actuator="cylinder")])
        log = logging.getLogger("tests.goals")
        self._servers: dict[str, Any] = {}

        def serve(action: Any, on_goal: Any, on_cancel: Any, result: Any) -> Any:
            server = self._servers[action.name] = GoalServer(action, on_goal, on_cancel, result, Later(log))
            server.start()
            return server

        node = SimpleNamespace(
            log=log,
            offers=lambda action: True,
            action_server=serve,
        )
        types = [CommandGoals(action) for action in COMMAND_ACTIONS]
        self.goals = ServedGoals(cast("Any", node), types, cast("Any", self.tool), lambda: self.state)

    def send(self, goal_id: str = "a", action: str = "TriggerGrip") -> None:
        import rospy
        from actionlib_msgs.msg import GoalID
        from end_effector_msgs.msg import EndEffectorActionGoal

        message = EndEffectorActionGoal(goal_id=GoalID(rospy.Time.now(), goal_id))
        self._servers[action].internal_goal_callback(message)

    def cancel(self, goal_id: str = "a", action: str = "TriggerGrip") -> None:
        from actionlib_msgs.msg import GoalID

        self._servers[action].internal_cancel_callback(GoalID(id=goal_id))

    def accepted(self, goal_id: str = "a") -> None:
        def active() -> bool:
            return any(
                goal.phase is Phase.RUNNING and goal.client.handle.get_goal_id().id == goal_id
                for goal in self.goals._goals.open
            )

        wait_until("the acceptance", active)

    def says(self, state: int = 0, command: int = NONE, cause: int = 0, **fields: Any) -> None:
        given = {"begun": 5, "count": 7, "command": Command(command), "cause": Cause(cause), **fields}
        self.goals.on_status(status(EndEffectorState(state), **given))

    def end(self, goal_id: str = "a", action: str = "TriggerGrip") -> tuple[str, str]:
        """Names of status and outcome, once it is there."""
        from actionlib_msgs.msg import GoalStatus
        from end_effector_msgs.msg import Outcome

        def found() -> list[Any]:
            sent = self._servers[action].result_pub.sent
            return [each for each in sent if each.status.goal_id.id == goal_id]

        (message,) = wait_until(f"the result of {goal_id}", found)
        status = next(name for name in STATUSES if getattr(GoalStatus, name) == message.status.status)
        outcome = next(
            name
            for name, value in vars(Outcome).items()
            if name.isupper() and value == message.result.outcome
        )
        assert message.result.state == self.state.state
        assert message.result.reason == message.status.text
        assert bool(message.result.reason) == (outcome != "SUCCEEDED"), message
        self.result = message.result
        return status, outcome
