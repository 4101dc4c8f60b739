"""The server of one action: actionlib's, with bounded input, with a reason in every result, and with cancels
that arrive before their goal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import actionlib
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

from end_effector_hal.control.goals import NOT_BEGUN, Ending, Outcome
from end_effector_hal.nodes.interface import Action
from end_effector_hal.nodes.transport import ClientGoal
from end_effector_hal.ros1.connections import MessageMaker, message_class
from end_effector_hal.wires import now_us

from ._later import Later

REMEMBERED = 1000
OVERTAKES_US = 5_000_000


class Cancels:
    """Remembers cancels for goals that are yet to come.

    A cancel by id counts whenever its goal comes; the newest 1000 ids are remembered. A cancel by time counts for
    goals that come within 5 s after it, for it is measured with clocks of other machines, which may be wrong:
    afterwards a goal that is stamped before it comes from a clock that is behind, and was not overtaken.
    """

    def __init__(self) -> None:
        self._ids: dict[str, None] = {}
        self._stamp_ns, self._until_us = 0, 0

    def add(self, goal_id: str, stamp_ns: int, now_us: int) -> None:
        """A cancel came: of an id (empty: none), of all goals up to a stamp (0: none)."""
        if goal_id:
            self._ids.pop(goal_id, None)
            self._ids[goal_id] = None
            if len(self._ids) > REMEMBERED:
                del self._ids[next(iter(self._ids))]
        if stamp_ns:
            before_ns = self._stamp_ns if now_us <= self._until_us else 0
            self._stamp_ns, self._until_us = max(stamp_ns, before_ns), now_us + OVERTAKES_US

    def cover(self, goal_id: str, stamp_ns: int, now_us: int) -> bool:
        """Whether a goal that has just come was cancelled before (a stamp of 0: it has none)."""
        by_time = bool(stamp_ns) and stamp_ns <= self._stamp_ns and now_us <= self._until_us
        return goal_id in self._ids or by_time


OPEN, LISTED, LONGEST_ID = 10, 50, 500
"""Goals of one action that may wait for their answer at once, entries of its status list, characters of an id."""

UNREAD = 1000
"""Messages kept for a reader that is slow: each result is the last word about its goal."""
STATUS_HZ, FORGOTTEN_S = 5.0, 5.0
"""How often the list of goals is published, and how long a goal that has ended stays there; as actionlib does."""

ANSWER_AFTER_US = 100_000
"""``SimpleActionClient`` does not know its goal before ``send_goal`` has returned: of an answer that comes sooner it
hears nothing, and waits for ever."""

_DONE = (
    GoalStatus.PREEMPTED,
    GoalStatus.SUCCEEDED,
    GoalStatus.ABORTED,
    GoalStatus.REJECTED,
    GoalStatus.RECALLED,
)


@dataclass(frozen=True)
class ActionlibGoal:
    """A goal, by its handle in actionlib."""

    handle: Any
    make_result: Callable[[Any], Any] = field(compare=False)
    make_feedback: Callable[[Any], Any] = field(compare=False)

    @property
    def request(self) -> Any:
        """The goal: it has no options."""
        return self.handle.get_goal()

    def begin(self) -> None:
        """It is ACTIVE."""
        self.handle.set_accepted()

    def publish_feedback(self, feedback: Any) -> None:
        """How far it is."""
        self.handle.publish_feedback(self.make_feedback(feedback))

    def end(self, ending: Ending, result: Any) -> None:
        """SUCCEEDED, PREEMPTED or ABORTED; RECALLED or REJECTED where it was not begun."""
        ends = {Outcome.SUCCEEDED: self.handle.set_succeeded, Outcome.CANCELLED: self.handle.set_canceled}
        if ending.seconds is not None:
            end = ends.get(ending.outcome, self.handle.set_aborted)
        else:
            not_executed = ending.outcome is Outcome.NOT_EXECUTED
            end = self.handle.set_canceled if not_executed else self.handle.set_rejected
        end(self.make_result(result), ending.reason)


class GoalServer(actionlib.ActionServer):  # type: ignore[misc]
    """Passes on goals and cancels of one action; it does not decide what becomes of them.

    - A stamp that is ahead of now counts as now, of a goal and of a cancel; what a cancel covers that comes before
      its goal stands at :class:`Cancels`.
    - A goal beyond ``OPEN`` open ones is rejected in words, without a place in the list that is published.
    - No result goes out earlier than 0.1 s after its goal came.
    - A result that actionlib makes by itself gets its outcome, NOT_EXECUTED, and words.

    Args:
        action: its name and type.
        on_goal, on_cancel: called with a goal, under the lock of this server.
        result: makes the result of a goal that this server refuses.
        later: calls what is due later.
    """

    def __init__(
        self,
        action: Action,
        on_goal: Callable[[ClientGoal], None],
        on_cancel: Callable[[ClientGoal], bool],
        result: Callable[[Ending], Any],
        later: Later,
    ) -> None:
        make_result = MessageMaker(message_class(f"{action.type}Result"))
        make_feedback = MessageMaker(message_class(f"{action.type}Feedback"))

        def goal_of(handle: Any) -> ActionlibGoal:
            return ActionlibGoal(handle, make_result, make_feedback)

        super().__init__(
            action.name,
            message_class(f"{action.type}Action"),
            lambda handle: on_goal(goal_of(handle)),
            lambda handle: on_cancel(goal_of(handle)),
            auto_start=False,
        )
        self._name, self._later = action.name, later
        self._result: Callable[[Ending], Any] = lambda ending: make_result(result(ending))
        self._cancels = Cancels()
        self._came: dict[str, int] = {}

    def initialize(self) -> None:
        """Begin to listen, without waiting for Nagle; parameters of actionlib change nothing."""
        name = rospy.remap_name(self._name)  # a remap names the action, not its topics
        send = partial(rospy.Publisher, tcp_nodelay=True, queue_size=UNREAD)
        self.status_pub = send(f"{name}/status", GoalStatusArray, latch=True)
        self.result_pub = send(f"{name}/result", self.ActionResult)
        self.feedback_pub = send(f"{name}/feedback", self.ActionFeedback)
        hear = partial(rospy.Subscriber, tcp_nodelay=True)
        self.goal_sub = hear(f"{name}/goal", self.ActionGoal, self.internal_goal_callback)
        self.cancel_sub = hear(f"{name}/cancel", GoalID, self.internal_cancel_callback)
        self.status_list_timeout = rospy.Duration(FORGOTTEN_S)
        self.status_timer = rospy.Timer(rospy.Duration(1 / STATUS_HZ), self.publish_status_async)

    def close(self) -> None:
        """Send the results that are not sent yet."""
        self._later.close()

    # In place of actionlib's own.

    def internal_cancel_callback(self, goal_id: Any) -> None:
        """A cancel came."""
        if len(goal_id.id) > LONGEST_ID:
            return  # a goal with such an id is never begun
        with self.lock:
            stamp = min(goal_id.stamp, rospy.Time.now())
            self._cancels.add(goal_id.id, stamp.to_nsec(), now_us())
            super().internal_cancel_callback(GoalID(stamp, goal_id.id))
            self.last_cancel = rospy.Time()  # Cancels knows better
            self._shorten()

    def internal_goal_callback(self, goal: Any) -> None:
        """A goal came."""
        with self.lock:
            now = rospy.Time.now()
            goal_id = GoalID(
                min(goal.goal_id.stamp, now), goal.goal_id.id or self.id_generator.generate_ID().id
            )
            if not any(tracker.status.goal_id.id == goal_id.id for tracker in self.status_list):
                if reason := self._refusal(goal_id.id):
                    self._refuse(goal_id, reason)
                    return
                self._came[goal_id.id] = now_us()
                if self._cancels.cover(goal_id.id, goal_id.stamp.to_nsec(), now_us()):
                    super().internal_cancel_callback(GoalID(id=goal_id.id))
            # a goal has no options: nothing else of what came is kept
            super().internal_goal_callback(self.ActionGoal(goal_id=goal_id))
            self._shorten()

    def publish_result(self, status: Any, result: Any) -> None:
        """A goal has come to its end."""
        if result.outcome == Outcome.NOT_EXECUTED and not result.reason:
            result = self._result(Ending(Outcome.NOT_EXECUTED, NOT_BEGUN))
        status.text = status.text or result.reason
        self._answer(copy(status), result)

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """A goal has come further."""
        with _while_topics_are_open():
            super().publish_feedback(status, feedback)

    def publish_status(self) -> None:
        """Tell all that are listed."""
        with _while_topics_are_open():
            super().publish_status()

    def _refusal(self, goal_id: str) -> str:
        if len(goal_id) > LONGEST_ID:
            return f"The id of the goal is longer than {LONGEST_ID} characters."
        if len(self._came) >= OPEN:
            return f"{OPEN} goals of {self._name} wait for their answer: no more are accepted. Wait for their end."
        return ""

    def _refuse(self, goal_id: Any, reason: str) -> None:
        status = GoalStatus(goal_id, GoalStatus.REJECTED, reason)
        send = partial(self._send, status, self._result(Ending(Outcome.REJECTED, reason)))
        # what is too long to be kept does not wait
        self._later.put(0 if len(goal_id.id) > LONGEST_ID else now_us() + ANSWER_AFTER_US, send)

    def _answer(self, status: Any, result: Any) -> None:
        def send() -> None:
            self._send(status, result)
            with self.lock:
                self._came.pop(status.goal_id.id, None)
                self.publish_status()

        self._later.put(self._came.get(status.goal_id.id, 0) + ANSWER_AFTER_US, send)

    def _send(self, status: Any, result: Any) -> None:
        message = self.ActionResult(status=status, result=result)
        message.header.stamp = rospy.Time.now()
        with _while_topics_are_open():
            self.result_pub.publish(message)

    def _shorten(self) -> None:
        """Forget the oldest entries that are no open goals."""
        spare = [each for each in self.status_list if each.goal is None or each.status.status in _DONE]
        for tracker in spare[: max(0, len(self.status_list) - LISTED)]:
            self.status_list.remove(tracker)


@contextmanager
def _while_topics_are_open() -> Iterator[None]:
    """At the end of the node they are closed, while timers of actionlib and connections still come to theirs."""
    try:
        yield
    except rospy.ROSException:
        if not rospy.core.is_shutdown_requested():
            raise
