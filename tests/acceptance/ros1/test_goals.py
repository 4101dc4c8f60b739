"""Goals and cancels as no well-behaved client gives them: each is answered, and in nobody's way."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros
SUCCEEDED, ABORTED, REJECTED, RECALLED = 3, 4, 5, 8
UNREAD = 500  # fewer than are kept for a slow reader
GRIPPED, GRIPPING = EndEffectorState.GRIPPED, EndEffectorState.GRIPPING


class Raw:
    """The topics of one action, without actionlib's client."""

    def __init__(self, system: Any, action: str) -> None:
        import rospy
        from actionlib_msgs.msg import GoalID
        from end_effector_msgs.msg import EndEffectorActionGoal, EndEffectorActionResult

        self._system, self._kinds = system, (EndEffectorActionGoal, GoalID)
        self._goal = rospy.Publisher(f"{action}/goal", EndEffectorActionGoal, queue_size=5000)
        self._cancel = rospy.Publisher(f"{action}/cancel", GoalID, queue_size=5000)
        self.results: dict[str, Any] = {}
        self._results = rospy.Subscriber(f"{action}/result", EndEffectorActionResult, self._came)
        connected = (self._goal.get_num_connections, self._cancel.get_num_connections)
        system.until("connections", lambda: all(each() for each in connected))
        system.until("results", self._results.get_num_connections)

    def goal(self, goal_id: str) -> None:
        import rospy

        kind, key = self._kinds
        self._goal.publish(kind(goal_id=key(rospy.Time.now(), goal_id)))

    def cancel(self, goal_id: str = "", ahead_s: float | None = None) -> None:
        import rospy

        later = rospy.Time() if ahead_s is None else rospy.Time.now() + rospy.Duration.from_sec(ahead_s)
        self._cancel.publish(self._kinds[1](later, goal_id))

    def result(self, goal_id: str) -> Any:
        return self._system.until(f"the result of {goal_id}", lambda: self.results.get(goal_id))

    def close(self) -> None:
        for each in (self._goal, self._cancel, self._results):
            each.unregister()

    def _came(self, message: Any) -> None:
        self.results[message.status.goal_id.id] = message


@pytest.fixture
def grips(system: Any) -> Iterator[Raw]:
    raw = Raw(system, "TriggerGrip")
    yield raw
    raw.close()


@pytest.fixture
def drops(system: Any) -> Iterator[Raw]:
    raw = Raw(system, "Drop")
    yield raw
    raw.close()


def listed(system: Any, action: str, goal_id: str) -> None:
    """The server has taken it up."""
    import rospy
    from actionlib_msgs.msg import GoalStatusArray

    def names(message: Any) -> list[str]:
        return [status.goal_id.id for status in message.status_list]

    system.until(
        f"{goal_id} in the status",
        lambda: goal_id in names(rospy.wait_for_message(f"{action}/status", GoalStatusArray)),
    )


def test_a_goal_that_its_cancel_overtakes_is_not_executed_and_says_so(system: Any, grips: Raw) -> None:
    before = system.edges()
    grips.cancel("overtaken")
    listed(system, "TriggerGrip", "overtaken")
    grips.goal("overtaken")
    answer = grips.result("overtaken")
    assert (answer.status.status, answer.result.outcome) == (RECALLED, 0)
    assert answer.result.reason == answer.status.text
    assert answer.result.reason == "The goal was cancelled before it was begun: it was not executed."
    assert answer.result.state == EndEffectorState.STAND_BY
    assert system.edges() == before


@pytest.mark.parametrize("ahead_s", [60.0, 400_000_000.0])
def test_a_cancel_of_a_clock_that_is_ahead_blocks_nothing(system: Any, drops: Raw, ahead_s: float) -> None:
    system.grip()
    drops.cancel(f"somebody's {ahead_s}", ahead_s)
    listed(system, "Drop", f"somebody's {ahead_s}")
    assert system.run("Drop")[1].outcome == 5


def test_a_flood_of_goals_leaves_threads_as_they_are_and_a_drop_gets_through(system: Any, grips: Raw) -> None:
    system.grip()
    grips.goal("first")
    grips.result("first")
    pid, sent, end = system.pid_of("/HALMain"), 0, threading.Event()

    def threads() -> int:
        return len(os.listdir(f"/proc/{pid}/task"))

    counts = [threads()]

    def flood() -> None:
        nonlocal sent
        while not end.wait(0.001):
            if sent - len(grips.results) < UNREAD:
                grips.goal(f"flood {sent}")
                sent += 1

    flooding = threading.Thread(target=flood)
    flooding.start()
    try:
        system.until("a flood", lambda: counts.append(threads()) or len(grips.results) > 1500)
        drop = system.send("Drop")
        system.until("its end", lambda: counts.append(threads()) or drop.ended())
    finally:
        end.set()
        flooding.join()
    status, result = drop.result()
    assert (status, result.outcome) == (SUCCEEDED, 5), result.reason

    def unanswered() -> list[int]:
        return [number for number in range(sent) if f"flood {number}" not in grips.results]

    with suppress(AssertionError):
        system.until("all answers", lambda: not unanswered())
    assert unanswered() == [], f"of {sent}"
    assert max(counts) <= counts[0] + 3, counts
    assert any("wait for their answer" in each.result.reason for each in grips.results.values())


def ends_of(system: Any, signal_number: int) -> Any:
    """What becomes of HALMain at a signal: nothing of it is a traceback, and it is there again."""
    log, pid = system.folder / "launch.log", system.pid_of("/HALMain")
    said, last = len(log.read_text()), system.state.header.seq
    count = len(system.states)
    os.kill(pid, signal_number)

    def again() -> Any:
        system.until("its return", lambda: any(each.header.seq < last for each in system.states[count:]))
        text = log.read_text()[said:]
        assert "Traceback" not in text, text
        assert "closed topic" not in text, text

    return again


def test_a_goal_in_flight_is_answered_when_the_launch_ends(system: Any, tmp_path: Any) -> None:
    import actionlib
    import rospy
    from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal

    from end_effector_hal.description import load, profile_path
    from end_effector_lab.demo._world import World

    with World(load(profile_path()), "nominal", tmp_path) as world:
        launch = system.launch(world, name="ended", env={"ROS_NAMESPACE": "/cell_2"})
        client = actionlib.ActionClient("/cell_2/TriggerGrip", EndEffectorAction)
        assert client.wait_for_server(rospy.Duration(60))
        world.choose("never-confirms:top_vacuum")
        states: list[int] = []

        def gripping() -> bool:
            handle = client.send_goal(
                EndEffectorGoal(), feedback_cb=lambda _, said: states.append(said.state)
            )
            goals.append(handle)
            done = actionlib.CommState.DONE
            system.until("feedback", lambda: GRIPPING in states or handle.get_comm_state() == done)
            return GRIPPING in states

        goals: list[Any] = []
        system.until("a grip", gripping)
        os.kill(launch.pid, signal.SIGINT)
        goal = goals[-1]
        system.until("its end", lambda: goal.get_comm_state() == actionlib.CommState.DONE)
        assert launch.wait_for_end(timeout_s=60.0) == 0
        client.stop()
    assert goal.get_result() is not None, goal.get_goal_status_text()
    assert (goal.get_goal_status(), goal.get_result().outcome) == (ABORTED, 4)
    assert goal.get_result().reason
    assert "Traceback" not in launch.text()
    assert "closed topic" not in launch.text()


# The server keeps its answer for 0.1 s: where the machine lets a client wait longer than that, the goal is sent again
OF_A_BUSY_MACHINE = """
import time
import actionlib, rospy
from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal

rospy.init_node("busy", anonymous=True)
client = actionlib.SimpleActionClient("TriggerGrip", EndEffectorAction)
assert client.wait_for_server(rospy.Duration(30))
send = client.action_client.send_goal

def is_sent_and_returns_late(*arguments):
    handle = send(*arguments)
    time.sleep(0.03)
    return handle

client.action_client.send_goal = is_sent_and_returns_late
for _ in range(20):
    begun = time.monotonic()
    client.send_goal(EndEffectorGoal())
    if time.monotonic() - begun < 0.08:
        break
print(client.wait_for_result(rospy.Duration(20)), client.get_state())
"""


def test_a_refusal_waits_until_a_simple_client_listens(system: Any) -> None:
    system.grip()
    client = system.cli("python3", "-c", OF_A_BUSY_MACHINE)
    assert client.stdout.strip() == f"True {REJECTED}", client.stderr
