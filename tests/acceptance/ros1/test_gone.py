"""Nodes that hang or die: what they held stays held, and no result lies."""

from __future__ import annotations

import os
import signal
import time
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros
ABORTED, REJECTED = 4, 5


def test_a_command_to_a_node_that_hangs_is_never_executed(system: Any) -> None:
    """The client was told that the drop failed: it must not happen when the node goes on."""
    from end_effector_msgs.msg import Outcome

    system.run("TriggerGrip")
    before, pid = system.edges(), system.pid_of("/Grip")
    os.kill(pid, signal.SIGSTOP)
    try:
        system.until("the alarm", lambda: system.state.state == EndEffectorState.OFF)
        assert any("Grip is silent" in alarm for alarm in system.state.alarms)
        assert system.state.held
        assert not system.state.lift_allowed
        status, result = system.send("Drop").result()
    finally:
        os.kill(pid, signal.SIGCONT)
    assert (status, result.outcome) == (REJECTED, Outcome.UNREACHABLE)
    assert result.reason == "The node Grip does not answer."
    system.wait_for(EndEffectorState.GRIPPED)
    time.sleep(0.5)
    assert system.state.state == EndEffectorState.GRIPPED
    assert system.edges() == before
    assert system.run("Drop")[1].outcome == Outcome.SUCCEEDED


def test_a_goal_ends_when_its_node_dies_and_the_tool_is_unwound(system: Any) -> None:
    from end_effector_msgs.msg import Outcome

    system.world.choose("never-confirms:top_vacuum")
    goal = system.send("TriggerGrip")
    system.until("the last step", lambda: list(system.state.outputs) == [True, True, True])
    begun = len(system.edges())
    os.kill(system.pid_of("/Grip"), signal.SIGKILL)
    status, result = goal.result()
    assert (status, result.outcome) == (ABORTED, Outcome.UNREACHABLE)
    assert "The node Grip" in result.reason
    off = [("SODIMM_212", 0), ("SODIMM_210", 0), ("SODIMM_208", 0)]
    system.until("all inactive, in reverse order", lambda: system.edges()[begun:] == off)
    system.wait_for(EndEffectorState.STAND_BY, EndEffectorState.GRIP_ERROR)


def test_hal_main_that_dies_while_gripped_changes_nothing(system: Any) -> None:
    system.run("TriggerGrip")
    before, count = system.edges(), len(system.states)
    last = system.state.header.seq
    os.kill(system.pid_of("/HALMain"), signal.SIGKILL)
    # it counts from 1 again; the first may be missed
    system.until("its return", lambda: any(state.header.seq < last for state in system.states[count:]))
    system.wait_for(EndEffectorState.GRIPPED)
    assert system.edges() == before
