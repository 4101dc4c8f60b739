"""``/ArmToolChanger``, the first of two steps of an unlock (IL-02): refused, taken, and over after its time."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import Description, ToolChanger, load, profile_path
from end_effector_lab.demo._world import World

pytestmark = pytest.mark.ros
SUCCEEDED, REJECTED = 3, 5
STAND_BY, LOCKED, UNLOCKED = 6, 1, 2
ARM_S = 5.0
ARM_FIRST = (REJECTED, "IL-02: no sensor shows where the tool is: arm first, then unlock within 5 s.")


class Blind:
    """A tool whose stand has no sensor, in a namespace of its own."""

    def __init__(self, system: Any) -> None:
        import actionlib
        import rospy
        from end_effector_msgs.msg import EndEffectorAction, EndEffectorState
        from std_srvs.srv import Trigger

        self.until, self.states = system.until, []
        self._subscriber = rospy.Subscriber("/blind/EndEffectorState", EndEffectorState, self.states.append)
        self._arm = rospy.ServiceProxy("/blind/ArmToolChanger", Trigger)
        self._clients = {
            name: actionlib.SimpleActionClient(f"/blind/{name}", EndEffectorAction)
            for name in ("LockToolChanger", "UnlockToolChanger")
        }
        assert all(client.wait_for_server(rospy.Duration(60)) for client in self._clients.values())
        self._arm.wait_for_service(60)
        self.until("rest", lambda: self.states and self.states[-1].state == STAND_BY and self.locked())

    def locked(self) -> bool:
        return bool(self.states[-1].tool_changer == LOCKED)

    def arm(self) -> None:
        answer = self._arm()
        assert answer.success, answer.message

    def run(self, action: str) -> tuple[int, str]:
        """Status and reason of a goal."""
        import rospy
        from end_effector_msgs.msg import EndEffectorGoal

        client = self._clients[action]
        client.send_goal_and_wait(EndEffectorGoal(), rospy.Duration(60))
        return client.get_state(), client.get_result().reason

    def until_later(self, seconds: float) -> None:
        """So much of the tool's own time goes by."""
        end = self.states[-1].header.stamp.to_sec() + seconds
        self.until(f"{seconds:g} s", lambda: self.states[-1].header.stamp.to_sec() > end)

    def close(self) -> None:
        self._subscriber.unregister()


def without_stand() -> Description:
    """The shipped tool, whose codec carries no bit of that name."""
    shipped = load(profile_path())
    assert shipped.tool_changer
    keys = {**shipped.tool_changer.model_dump(exclude_unset=True), "stand_bit": "none", "arm_s": ARM_S}
    return shipped.model_copy(update={"tool_changer": ToolChanger.model_validate(keys)})


@pytest.fixture
def blind(system: Any, tmp_path: Path) -> Iterator[Blind]:
    with World(without_stand(), "nominal", tmp_path) as world:
        launch = system.launch(world, name="blind", env={"ROS_NAMESPACE": "/blind"})
        tool = None
        try:
            tool = Blind(system)
            yield tool
        finally:
            if tool:
                tool.close()
            launch.end(signal_number=signal.SIGINT, patience_s=20.0)


def test_without_a_sensor_an_unlock_is_armed_and_what_was_armed_is_over_in_its_time(blind: Blind) -> None:
    def is_next(*wanted: tuple[int, str]) -> bool:
        """Whether an unlock ends so; one that comes before the vacuums' half second (IL-01) is no answer yet."""
        end = blind.run("UnlockToolChanger")
        assert end in wanted or end[1].startswith("IL-01"), end
        return end == wanted[0]

    def unlocks() -> bool:
        blind.arm()
        return is_next((SUCCEEDED, ""), ARM_FIRST)  # on a machine that takes so long between the two steps

    blind.until("a refusal", lambda: is_next(ARM_FIRST))
    blind.until("an unlock", unlocks)
    # a result may overtake the state, over another connection
    blind.until(
        "UNLOCKED", lambda: any(it.tool_changer == UNLOCKED and it.unlock_output for it in blind.states)
    )
    assert blind.run("LockToolChanger")[0] == SUCCEEDED
    blind.until("LOCKED", blind.locked)

    blind.arm()
    blind.until_later(ARM_S + 3.0)
    blind.until("a refusal again", lambda: is_next(ARM_FIRST))
    assert blind.locked()
