"""A held part, watched: what goes wrong is in the state and in the diagnostics, and releases nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from end_effector_hal.recording import read_alarms
from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros
OK, WARN, ERROR = 0, 1, 2
HELD = [("SODIMM_208", 1), ("SODIMM_210", 1), ("SODIMM_212", 1)]


@pytest.fixture
def diagnostics(system: Any) -> Iterator[Callable[[], Any]]:
    """The newest of HALMain."""
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray

    newest: list[Any] = []

    def take(message: Any) -> None:
        newest.extend(status for status in message.status if status.name == "HALMain")

    subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, take)
    yield lambda: newest[-1] if newest else None
    subscriber.unregister()


def told(system: Any, words: str) -> bool:
    return any(words in alarm for alarm in system.state.alarms)


def test_a_weak_grip_is_told_until_it_is_over_and_reset(system: Any, diagnostics: Callable[[], Any]) -> None:
    system.world.choose("leak:top_vacuum")
    system.grip()
    system.until("the alarm", lambda: told(system, "Weak grip: Top vacuum"))
    state = system.state
    assert (state.state, state.lift_allowed, state.secure) == (EndEffectorState.GRIPPED, True, False)
    system.until("a warning", lambda: (found := diagnostics()) and "Weak grip" in found.message)
    assert diagnostics().level == WARN
    system.world.choose("nominal")
    system.until("secure", lambda: system.state.secure)
    system.until("what is over", lambda: told(system, "Over: Top vacuum"))
    done = system.cli("rosrun", "end_effector_hal", "supervisor", "__name:=resetter", "_script:=reset; quit")
    assert (done.returncode, "reset: SUCCEEDED" in done.stdout) == (0, True), done.stdout + done.stderr
    system.until("no alarm", lambda: not told(system, "Top vacuum"))
    assert system.state.state == EndEffectorState.GRIPPED
    assert system.run("Drop")[0] == 3
    written = system.folder / "log" / "alarms.csv"
    system.until(
        "the recording", lambda: any("Weak grip: Top vacuum" in row.text for row in read_alarms(written))
    )


def test_a_lost_grip_is_an_error_that_only_a_drop_ends(system: Any, diagnostics: Callable[[], Any]) -> None:
    system.grip()
    edges = system.edges()
    assert edges[-3:] == HELD
    system.world.choose("lost-after:bottom_vacuum:0.1")
    state = system.wait_for(EndEffectorState.GRIP_ERROR)
    assert (state.held, state.lift_allowed) == (True, False)
    assert state.reason.startswith("Bottom vacuum was lost: ")
    assert state.cause_actuator == "bottom_vacuum"
    assert told(system, "only a Drop releases")
    system.until("an error", lambda: (found := diagnostics()) and found.level == ERROR)
    assert "Bottom vacuum was lost" in diagnostics().message
    assert system.edges() == edges, "a loss moves no line"
    status, result = system.run("TriggerGrip")
    assert (status, result.outcome) == (5, 1), "rejected"
    assert system.run("Drop")[0] == 3
    assert [line for line, level in system.edges()[len(edges) :] if not level] == [
        "SODIMM_212", "SODIMM_210", "SODIMM_208",
    ]  # fmt: skip


def test_silence_while_held_freezes_and_is_told(system: Any) -> None:
    system.grip()
    edges = system.edges()
    system.world.choose("silent-after:0")
    system.until("UNKNOWN", lambda: list(system.state.evidence) == [0, 0, 0])
    system.until("the alarm", lambda: told(system, "No reading: Bottom vacuum is held"))
    state = system.state
    assert (state.state, state.held, state.lift_allowed) == (EndEffectorState.GRIPPED, True, False)
    assert all(margin != margin for margin in state.margins), "NaN: not known"
    system.until("positions", lambda: (system.state.tool_position, system.state.tool_stand) == (0, 0))
    assert system.edges() == edges
    system.world.choose("nominal")
    system.until("a fresh reading", lambda: system.state.lift_allowed)
    assert system.state.state == EndEffectorState.GRIPPED
    assert system.edges() == edges


def test_maintenance_stands_in_the_state_and_refuses_goals(system: Any) -> None:
    done = system.cli("rosservice", "call", "/SetCylinder", "data: true")
    try:
        assert "success: True" in done.stdout
        system.until("maintenance", lambda: system.state.maintenance)
        assert list(system.state.outputs) == [False, True, False]
        assert told(system, "Maintenance: Cylinder active")
        assert 0 < system.state.time_left_s <= 30
        status, result = system.run("TriggerGrip")
        assert status == 5
        assert result.reason.startswith("IL-12: a grip is refused during maintenance.")
        status, result = system.run("UnlockToolChanger")
        assert status == 5
        assert result.reason.startswith("IL-01")
    finally:
        done = system.cli("rosservice", "call", "/SetCylinder", "data: false")
    assert "success: True" in done.stdout
    system.until("its end", lambda: not system.state.maintenance)


def test_the_tool_changer_is_not_unlocked_by_hand_while_a_part_is_held(system: Any) -> None:
    system.grip()
    edges = system.edges()
    done = system.cli("rosservice", "call", "/SetToolChanger", "data: true")
    assert "success: False" in done.stdout
    assert "IL-01: unlock only in STAND_BY; the end-effector is GRIPPED." in done.stdout
    assert system.edges() == edges
