"""The server of one action in virtual time, without a master."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

START_S = 1_700_000_000


class Clock:
    """Both clocks: that of ROS and the monotonic one."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        import rospy

        self._patch, self.us = monkeypatch, 5_000_000
        monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
        monkeypatch.setattr("end_effector_hal.ros1._actions.now_us", lambda: self.us)
        self.jobs: list[tuple[int, Callable[[], None]]] = []
        self.pass_s(0.0)

    @property
    def ros(self) -> Any:
        import rospy

        return rospy.Time(START_S + self.us // 1_000_000, self.us % 1_000_000 * 1000)

    def put(self, due_us: int, job: Callable[[], None]) -> None:
        """In place of Later."""
        if due_us <= self.us:
            job()
        else:
            self.jobs.append((due_us, job))

    def pass_s(self, seconds: float) -> None:
        import rospy

        self.us += round(seconds * 1e6)
        self._patch.setattr(rospy.rostime, "_rostime_current", self.ros)
        due = [job for at, job in self.jobs if at <= self.us]
        self.jobs = [(at, job) for at, job in self.jobs if at > self.us]
        for job in due:
            job()


class Wire:
    """In place of a publisher."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.closed = False

    def publish(self, message: Any) -> None:
        import rospy

        if self.closed:
            raise rospy.ROSException("publish() to a closed topic")
        self.sent.append(message)


class Server:
    """A server that is told what to answer."""

    def __init__(self, clock: Clock) -> None:
        import rospy

        from end_effector_hal.nodes.interface import TRIGGER_GRIP
        from end_effector_hal.nodes.transport import ResultMessage
        from end_effector_hal.ros1._actions import GoalServer

        self.clock, self.goals, self.cancelled = clock, [], []
        self.server: Any = GoalServer(
            TRIGGER_GRIP,
            lambda goal: self.goals.append(goal.handle),
            lambda goal: self.cancelled.append(goal.handle) is None,
            lambda ending: ResultMessage(ending.outcome, ending.outcome.name, 6, "STAND_BY", ending.reason),
            clock,  # type: ignore[arg-type]
        )
        self.server.status_list_timeout = rospy.Duration(5.0)
        self.results, self.status, self.feedback = Wire(), Wire(), Wire()
        self.server.result_pub, self.server.status_pub = self.results, self.status
        self.server.feedback_pub = self.feedback
        self.server.started = True

    def result(self, outcome: int, reason: str) -> Any:
        """As HALMain makes it."""
        from end_effector_hal.control.goals import Ending, Outcome

        return self.server._result(Ending(Outcome(outcome), reason))

    def goal(self, goal_id: str = "a", ahead_s: float = 0.0, stamp: Any = None, part: str = "") -> None:
        import rospy
        from actionlib_msgs.msg import GoalID
        from end_effector_msgs.msg import EndEffectorActionGoal, EndEffectorGoal

        stamp = self.clock.ros + rospy.Duration.from_sec(ahead_s) if stamp is None else stamp
        goal = EndEffectorActionGoal(goal_id=GoalID(stamp, goal_id), goal=EndEffectorGoal(part=part))
        self.server.internal_goal_callback(goal)

    def cancel(self, goal_id: str = "", stamp: Any = None) -> None:
        import rospy
        from actionlib_msgs.msg import GoalID

        self.server.internal_cancel_callback(GoalID(stamp or rospy.Time(), goal_id))

    def ends(self) -> list[tuple[str, int, int]]:
        """Id, status and outcome of every result, each with words and the same ones in both places."""
        for each in self.results.sent:
            assert each.result.reason == each.status.text
            assert bool(each.result.reason) or each.result.outcome == 5
        return [
            (each.status.goal_id.id, each.status.status, each.result.outcome) for each in self.results.sent
        ]
