"""The client and the server of one action in ROS 1; only nodes with actions load actionlib.

The server is actionlib's, with bounded input, with a reason in every result, and with cancels that arrive before their
goal.
"""

from __future__ import annotations

import threading
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
from end_effector_hal.nodes.transport import ClientGoal, GoalMessage
from end_effector_hal.vocabulary import LONGEST_NAME, printable
from end_effector_hal.wires import now_us

from ._later import Later
from ._messages import MessageMaker, encodable, message_class

_SOON = rospy.Duration(0, 1_000_000)


class GoalSender:
    """Sends goals."""

    def __init__(self, action: Action) -> None:
        self._make = MessageMaker(message_class(f"{action.type}Goal"))
        self._client = actionlib.ActionClient(action.name, message_class(f"{action.type}Action"))
        self._handles: list[Any] = []
        """Handles of the sent goals; they are kept because actionlib's manager holds goals only weakly."""

    def is_ready(self) -> bool:
        """Return whether the server is connected."""
        return bool(self._client.wait_for_server(_SOON))

    def send(
        self, goal: GoalMessage, on_feedback: Callable[[Any], None], on_end: Callable[[Any, bool], None]
    ) -> None:
        """Send a goal; a goal that actionlib's client reports as LOST does not count as ended."""
        once = threading.Lock()

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE and once.acquire(blocking=False):
                on_end(handle.get_result(), handle.get_goal_status() == GoalStatus.SUCCEEDED)

        handle = self._client.send_goal(
            encodable(self._make(goal)), moved, lambda _handle, feedback: on_feedback(feedback)
        )
        self._handles.append(handle)

    def cancel_all(self) -> None:
        """Cancel every goal of this action."""
        self._client.cancel_all_goals()


REMEMBERED = 1000
OVERTAKES_US = 5_000_000


class Cancels:
    """Stores cancels for goals that have not arrived yet.

    A cancel by id is valid whenever its goal arrives; the newest 1000 ids are stored. A cancel by time is valid for
    goals that arrive within 5 s after it. Its stamp is from the clock of another machine, which may be wrong: a goal
    that arrives later with an earlier stamp comes from a clock that is behind, and was not overtaken.
    """

    def __init__(self) -> None:
        self._ids: dict[str, None] = {}
        self._stamp_ns, self._until_us = 0, 0

    def add(self, goal_id: str, stamp_ns: int, now_us: int) -> None:
        """Store a cancel: of an id (empty: none), of all goals up to a stamp (0: none)."""
        if goal_id:
            self._ids.pop(goal_id, None)
            self._ids[goal_id] = None
            if len(self._ids) > REMEMBERED:
                del self._ids[next(iter(self._ids))]
        if stamp_ns:
            before_ns = self._stamp_ns if now_us <= self._until_us else 0
            self._stamp_ns, self._until_us = max(stamp_ns, before_ns), now_us + OVERTAKES_US

    def cover(self, goal_id: str, stamp_ns: int, now_us: int) -> bool:
        """Return whether a goal that has just arrived was cancelled before (a stamp of 0: it has none)."""
        by_time = bool(stamp_ns) and stamp_ns <= self._stamp_ns and now_us <= self._until_us
        return goal_id in self._ids or by_time


OPEN, LISTED, LONGEST_ID = 10, 50, 500
"""Maximum number of open goals of one action, of entries in its status list, and of characters of a goal id."""

UNREAD = 1000
"""Number of messages kept for a slow reader, because each result is the last message about its goal."""
STATUS_HZ, FORGOTTEN_S = 5.0, 5.0
"""Rate at which the list of goals is to be published, and time for which an ended goal stays in it; the values of
actionlib.
"""

ANSWER_AFTER_US = 100_000
"""Earliest time of an answer after its goal, µs.

``SimpleActionClient`` ignores answers that arrive before ``send_goal`` has returned, and would then wait for ever.
"""

_DONE = (
    GoalStatus.PREEMPTED,
    GoalStatus.SUCCEEDED,
    GoalStatus.ABORTED,
    GoalStatus.REJECTED,
    GoalStatus.RECALLED,
)


@dataclass(frozen=True)
class ActionlibGoal:
    """A goal of a client, with its handle in actionlib."""

    handle: Any
    make_result: Callable[[Any], Any] = field(compare=False)
    make_feedback: Callable[[Any], Any] = field(compare=False)

    @property
    def request(self) -> Any:
        """The goal message."""
        return self.handle.get_goal()

    def begin(self) -> None:
        """Set the goal to ACTIVE."""
        self.handle.set_accepted()

    def publish_feedback(self, feedback: Any) -> None:
        """Publish the progress of the goal."""
        self.handle.publish_feedback(self.make_feedback(feedback))

    def end(self, ending: Ending, result: Any) -> None:
        """Set the goal to SUCCEEDED, PREEMPTED or ABORTED; if it was not begun, to RECALLED or REJECTED."""
        ends = {Outcome.SUCCEEDED: self.handle.set_succeeded, Outcome.CANCELLED: self.handle.set_canceled}
        if ending.seconds is not None:
            end = ends.get(ending.outcome, self.handle.set_aborted)
        else:
            not_executed = ending.outcome is Outcome.NOT_EXECUTED
            end = self.handle.set_canceled if not_executed else self.handle.set_rejected
        end(self.make_result(result), ending.reason)


class GoalServer(actionlib.ActionServer):  # type: ignore[misc]
    """Passes on goals and cancels of one action; it does not decide on them.

    - A stamp in the future counts as now, for a goal and for a cancel; :class:`Cancels` decides whether a cancel
      covers a goal that arrives after it.
    - If ``OPEN`` goals are open, a further one is rejected with a reason, and does not appear in the published list.
    - No result is sent earlier than 0.1 s after its goal arrived.
    - A result that actionlib makes by itself gets its outcome, NOT_EXECUTED, and a reason.

    Args:
        action: its name and type.
        on_goal, on_cancel: called with a goal, under the lock of this server.
        result: makes the result of a goal that this server refuses.
        later: calls functions at a later time.
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
        self._goal = message_class(f"{action.type}Goal")
        self._result: Callable[[Ending], Any] = lambda ending: make_result(result(ending))
        self._cancels = Cancels()
        self._came: dict[str, int] = {}

    def initialize(self) -> None:
        """Open the topics with tcp_nodelay (without Nagle's algorithm); actionlib's parameters have no effect."""
        name = rospy.remap_name(self._name)  # a remap names the action, not its topics
        send = partial(rospy.Publisher, tcp_nodelay=True, queue_size=UNREAD)
        self.status_pub = send(f"{name}/status", GoalStatusArray, latch=True)
        self.result_pub = send(f"{name}/result", self.ActionResult)
        self.feedback_pub = send(f"{name}/feedback", self.ActionFeedback)
        hear = partial(rospy.Subscriber, tcp_nodelay=True)
        self.goal_sub = hear(f"{name}/goal", self.ActionGoal, self.internal_goal_callback)
        self.cancel_sub = hear(f"{name}/cancel", GoalID, self.internal_cancel_callback)
        self.status_list_timeout = rospy.Duration(FORGOTTEN_S)

    def close(self) -> None:
        """Send the results that are not sent yet."""
        self._later.close()

    # In place of actionlib's own.

    def internal_cancel_callback(self, goal_id: Any) -> None:
        """Process a cancel."""
        if len(goal_id.id) > LONGEST_ID:
            return  # a goal with such an id is never begun
        with self.lock:
            stamp = min(goal_id.stamp, rospy.Time.now())
            self._cancels.add(goal_id.id, stamp.to_nsec(), now_us())
            super().internal_cancel_callback(GoalID(stamp, goal_id.id))
            self.last_cancel = rospy.Time()  # Cancels knows better
            self._shorten()

    def internal_goal_callback(self, goal: Any) -> None:
        """Process a new goal."""
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
            # nothing else of what came is kept
            part = printable(goal.goal.part, LONGEST_NAME)
            super().internal_goal_callback(self.ActionGoal(goal_id=goal_id, goal=self._goal(part=part)))
            self._shorten()

    def publish_result(self, status: Any, result: Any) -> None:
        """Send the result of a goal that has ended."""
        if result.outcome == Outcome.NOT_EXECUTED and not result.reason:
            result = self._result(Ending(Outcome.NOT_EXECUTED, NOT_BEGUN))
        status.text = status.text or result.reason
        self._answer(copy(status), result)

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """Publish the feedback of a goal."""
        with _while_topics_are_open():
            super().publish_feedback(status, feedback)

    def publish_status(self) -> None:
        """Publish the list of goals."""
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
        """Remove the oldest entries that are no open goals from the list."""
        spare = [each for each in self.status_list if each.goal is None or each.status.status in _DONE]
        for tracker in spare[: max(0, len(self.status_list) - LISTED)]:
            self.status_list.remove(tracker)


@contextmanager
def _while_topics_are_open() -> Iterator[None]:
    """Ignore errors of topics that are closed at the end of the node, while timers and connections still run."""
    try:
        yield
    except rospy.ROSException:
        if not rospy.core.is_shutdown_requested():
            raise
