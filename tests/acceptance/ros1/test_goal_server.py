"""The server of one action in virtual time, without a master: every terminal status with its outcome and words."""

from __future__ import annotations

import pytest

from tests.support.goal_server import START_S, Clock, Server

pytestmark = pytest.mark.ros
PENDING, ACTIVE, PREEMPTED, SUCCEEDED, ABORTED, REJECTED, PREEMPTING, RECALLING, RECALLED, LOST = range(10)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


@pytest.fixture
def server(clock: Clock) -> Server:
    return Server(clock)


def test_nothing_that_is_a_default_claims_a_success() -> None:
    from end_effector_msgs.msg import EndEffectorActionResult, EndEffectorResult, Outcome

    assert EndEffectorResult().outcome == Outcome.NOT_EXECUTED == 0
    assert EndEffectorActionResult().result.outcome == Outcome.NOT_EXECUTED
    numbers = (Outcome.REJECTED, Outcome.CANCELLED, Outcome.FAILED, Outcome.UNREACHABLE, Outcome.SUCCEEDED)
    assert numbers == (1, 2, 3, 4, 5)


def test_a_goal_that_was_overtaken_by_its_cancel_was_not_executed(server: Server, clock: Clock) -> None:
    server.cancel("a")
    clock.pass_s(0.01)
    server.goal("a")
    clock.pass_s(1.0)
    assert server.ends() == [("a", RECALLED, 0)]
    assert server.results.sent[0].result.state == 6
    assert "was not executed" in server.results.sent[0].result.reason
    assert server.goals == []


def test_a_cancel_by_id_counts_when_actionlib_has_forgotten_it(server: Server, clock: Clock) -> None:
    server.cancel("a")
    clock.pass_s(60.0)
    server.server.publish_status()
    assert server.server.status_list == []
    server.goal("a")
    clock.pass_s(1.0)
    assert server.ends() == [("a", RECALLED, 0)]
    assert server.goals == []


def test_a_goal_that_was_overtaken_by_a_cancel_by_time(server: Server, clock: Clock) -> None:
    sent = clock.ros
    clock.pass_s(0.01)
    server.cancel(stamp=clock.ros)
    server.goal("a", stamp=sent)
    clock.pass_s(1.0)
    assert server.ends() == [("a", RECALLED, 0)]
    assert server.goals == []


@pytest.mark.parametrize("ahead_s", [0.0, 60.0, 2_147_483_647.0 - START_S])
def test_a_cancel_that_is_stamped_ahead_of_now_counts_as_stamped_now(
    server: Server, clock: Clock, ahead_s: float
) -> None:
    import rospy

    server.goal("before")
    clock.pass_s(0.01)
    server.cancel(stamp=clock.ros + rospy.Duration.from_sec(ahead_s))
    assert [handle.get_goal_id().id for handle in server.cancelled] == ["before"]
    clock.pass_s(0.01)
    server.goal("after")
    assert [handle.get_goal_id().id for handle in server.goals] == ["before", "after"]
    assert server.goals[1].get_goal_status().status == PENDING


def test_a_goal_from_a_clock_that_is_behind_is_not_taken_for_overtaken_for_long(
    server: Server, clock: Clock
) -> None:
    server.cancel(stamp=clock.ros)
    clock.pass_s(6.0)
    server.goal("a", ahead_s=-60.0)
    assert len(server.goals) == 1


def test_goal_and_cancel_of_a_clock_that_is_ahead(server: Server, clock: Clock) -> None:
    """Its cancel by time covers what it has sent before, and nothing that it sends later."""
    import rospy

    server.goal("a", ahead_s=60.0)
    clock.pass_s(0.01)
    server.cancel(stamp=clock.ros + rospy.Duration(60))
    assert [handle.get_goal_id().id for handle in server.cancelled] == ["a"]
    clock.pass_s(0.01)
    server.goal("b", ahead_s=60.0)
    assert len(server.goals) == 2


def test_a_clock_that_was_set_back_blocks_nothing_for_long(server: Server, clock: Clock) -> None:
    import rospy

    server.cancel(stamp=clock.ros)
    clock.pass_s(6.0)
    server.goal("a", stamp=clock.ros - rospy.Duration(3600))
    assert len(server.goals) == 1


@pytest.mark.parametrize("cancelled", [False, True])
@pytest.mark.parametrize(
    ("end", "status", "outcome"),
    [
        ("set_succeeded", SUCCEEDED, 5),
        ("set_aborted", ABORTED, 3),
        ("set_aborted", ABORTED, 4),
        ("set_canceled", PREEMPTED, 2),
    ],
)
def test_an_accepted_goal_ends_with_its_outcome(
    server: Server, clock: Clock, end: str, status: int, outcome: int, cancelled: bool
) -> None:
    server.goal()
    handle = server.goals[0]
    handle.set_accepted()
    if cancelled:
        server.cancel("a")
        assert server.cancelled == [handle]
    clock.pass_s(1.0)
    words = "" if outcome == 5 else "why"
    getattr(handle, end)(server.result(outcome, words), words)
    assert server.ends() == [("a", status, outcome)]


@pytest.mark.parametrize("cancelled", [False, True])
@pytest.mark.parametrize("outcome", [1, 4])
def test_a_goal_that_was_not_accepted_is_rejected(
    server: Server, clock: Clock, outcome: int, cancelled: bool
) -> None:
    server.goal()
    if cancelled:
        server.cancel()
    server.goals[0].set_rejected(server.result(outcome, "why"), "why")
    assert server.ends() == [], "not within 0.1 s after the goal"
    clock.pass_s(0.1)
    assert server.ends() == [("a", REJECTED, outcome)]


def test_a_result_that_somebody_forgot_says_that_nothing_was_executed(server: Server, clock: Clock) -> None:
    server.goal()
    server.goals[0].set_rejected()
    clock.pass_s(0.1)
    assert [(status, outcome) for _, status, outcome in server.ends()] == [(REJECTED, 0)]


def test_a_goal_that_comes_twice_is_answered_once(server: Server, clock: Clock) -> None:
    server.goal()
    server.goal()
    assert len(server.goals) == 1
    server.goals[0].set_rejected(server.result(1, "why"), "why")
    server.goal()
    clock.pass_s(1.0)
    server.goal()
    assert server.ends() == [("a", REJECTED, 1)]


def test_a_goal_without_id_and_stamp_gets_both(server: Server, clock: Clock) -> None:
    import rospy

    server.cancel(stamp=clock.ros)
    clock.pass_s(0.1)
    server.goal("", stamp=rospy.Time())
    assert server.goals[0].get_goal_id().id
    assert server.goals[0].get_goal_id().stamp == clock.ros


def test_a_flood_of_goals_is_refused_in_words_and_takes_a_bounded_room(server: Server, clock: Clock) -> None:
    from end_effector_hal.ros1._actions import LISTED, OPEN

    for second in range(3):
        for number in range(1000):
            server.goal(f"{second}-{number}")
            clock.pass_s(0.001)
            for handle in server.goals:
                if handle.get_goal_status().status == PENDING:
                    handle.set_rejected(server.result(1, "busy"), "busy")
            assert len(server.server._came) <= OPEN
            assert len(server.server.status_list) <= LISTED
            assert len(clock.jobs) <= 101, "0.1 s of 1,000 goals a second"
    clock.pass_s(1.0)
    assert len(server.ends()) == 3000
    assert {(status, outcome) for _, status, outcome in server.ends()} == {(REJECTED, 1)}
    refused = [each.result.reason for each in server.results.sent if each.result.reason != "busy"]
    assert len(refused) > 2000
    assert set(refused) == {
        f"{OPEN} goals of TriggerGrip wait for their answer: no more are accepted. Wait for their end."
    }
    assert server.server._came == {}


def test_a_flood_of_cancels_takes_a_bounded_room_and_spares_the_open_goal(
    server: Server, clock: Clock
) -> None:
    from end_effector_hal.ros1._actions import LISTED

    server.goal("open")
    server.goals[0].set_accepted()
    for number in range(3000):
        server.cancel(f"nobody's {number}")
    assert len(server.server.status_list) == LISTED
    assert server.server.status_list[0].status.goal_id.id == "open"
    assert server.cancelled == []


def test_an_id_that_is_too_long_is_refused_and_not_kept(server: Server, clock: Clock) -> None:
    from end_effector_hal.ros1._actions import LONGEST_ID

    long = "x" * (LONGEST_ID + 1)
    server.cancel(long)
    server.goal(long)
    assert server.ends() == [(long, REJECTED, 1)]
    assert (clock.jobs, server.server.status_list, server.goals) == ([], [], [])
    assert not server.server._cancels.cover(long, 0, clock.us)


def test_nothing_but_id_and_stamp_of_a_goal_is_kept(server: Server, clock: Clock) -> None:
    from actionlib_msgs.msg import GoalID
    from end_effector_msgs.msg import EndEffectorActionGoal

    goal = EndEffectorActionGoal(goal_id=GoalID(clock.ros, "a"))
    goal.header.frame_id = "x" * 1_000_000
    server.server.internal_goal_callback(goal)
    assert server.server.status_list[0].goal.header.frame_id == ""


def test_closed_topics_at_the_end_are_no_traceback(
    server: Server, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    import rospy

    server.goal()
    handle = server.goals[0]
    for wire in (server.results, server.status, server.feedback):
        wire.closed = True
    with pytest.raises(rospy.ROSException):
        server.server.publish_status()
    monkeypatch.setattr(rospy.core, "_in_shutdown", True)
    server.server.publish_status_async(None)
    handle.set_accepted()
    handle.publish_feedback(None)
    handle.set_aborted(server.result(4, "why"), "why")
    clock.pass_s(1.0)
    assert server.results.sent == []


def test_of_a_goal_only_a_bounded_name_of_its_part_is_kept(server: Server) -> None:
    server.goal("a", part="lid")
    server.goal("b", part="l\0id" * 1_000_000)
    first, second = (handle.get_goal() for handle in server.goals)
    assert first.part == "lid"
    assert (len(second.part), second.part[:8]) == (64, "l?idl?id")
