"""A unit that the line owner took for dead, or that does not reach it: it claims nothing that it does not know."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import LineBusyError, OwnerError
from end_effector_hal.tool import Unit
from end_effector_hal.trace import EndEffectorState as State
from end_effector_hal.wires import Frame, WillStep, now_us

pytestmark = pytest.mark.wall
BOTTOM, CYLINDER, TOP = LINES = ("SODIMM_208", "SODIMM_210", "SODIMM_212")
OFF, ON = False, True


class Owner:
    """A line owner that does what a test says."""

    def __init__(self) -> None:
        self.active = dict.fromkeys(LINES, OFF)
        self.error: OSError | None = None
        self.will: tuple[WillStep, ...] = ()

    def levels(self) -> Mapping[str, bool]:
        if self.error:
            raise self.error
        return dict(self.active)

    def set(self, levels: Mapping[str, bool], will: Sequence[WillStep]) -> None:
        if self.error:
            raise self.error
        self.active |= levels
        self.will = tuple(will)

    def close(self, will: Sequence[WillStep]) -> None:
        pass


class Tool:
    """A gripping unit, and what its sensors show."""

    def __init__(self) -> None:
        self.owner, self.told = Owner(), list[Status]()
        self.unit = Unit(load(profile_path()), "grip", self.owner, self.told.append)
        self.confirmed = dict.fromkeys(LINES, OFF)
        self._seq = 0

    def until(self, what: Callable[[Status], bool], timeout_s: float = 10.0) -> Status:
        """Frames, until a status is as wanted."""
        end = time.monotonic() + timeout_s
        while not what(self.unit.status):
            assert time.monotonic() < end, self.unit.status
            self.frame()
            threading.Event().wait(0.01)
        return self.unit.status

    def frame(self, age_us: int = 0) -> None:
        self._seq += 1
        bottom, cylinder, top = (self.confirmed[line] for line in LINES)
        values = {
            "bottom": -80_000 if bottom else 0, "top": -80_000 if top else 0,
            "cylinder": 600_000 if cylinder else 0, "supply": 600_000,
            "cylinder_extended": cylinder, "cylinder_retracted": not cylinder,
            "locked": True, "unlocked": False, "tool_present": True, "in_stand": True, "estop_ok": True,
        }  # fmt: skip
        self.unit.frame(Frame(now_us() - age_us, self._seq, self._seq * 20, values))

    def states(self) -> list[State]:
        """Each once, in order."""
        seen = [State(status.ee) for status in self.told]
        return [state for i, state in enumerate(seen) if i == 0 or seen[i - 1] != state]

    def grip_to(self, step: int) -> None:
        """In GRIPPING, with the steps before confirmed."""
        self.until(lambda status: status.ee == State.STAND_BY and set(status.evidence) == {1})
        assert self.unit.command("grip").accepted
        for line in LINES[:step]:
            self.until(lambda _, line=line: self.owner.active[line])
            self.confirmed[line] = ON
        self.until(lambda status: status.outputs[step])


@pytest.fixture
def tool() -> Iterator[Tool]:
    made = Tool()
    made.unit.start()
    yield made
    made.owner.error = None
    made.unit.close()


def overtake(tool: Tool) -> None:
    """The will was executed, all of it, at once."""
    tool.owner.active = dict.fromkeys(LINES, OFF)
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.unit.lost(OwnerError("the lease ended."))


def test_a_will_that_was_executed_ends_the_grip_and_the_unit_adopts_what_it_finds(tool: Tool) -> None:
    tool.grip_to(2)
    overtake(tool)
    status = tool.until(lambda status: status.ee == State.STAND_BY)
    assert tool.states() == [State.OFF, State.STAND_BY, State.GRIPPING, State.OFF, State.STAND_BY]
    assert status.reason.startswith("The line owner took this program for dead")
    assert status.outputs == (OFF, OFF, OFF)
    assert tool.owner.active == dict.fromkeys(LINES, OFF), "nothing is activated by itself (IL-11)"
    tool.grip_to(0)
    assert tool.unit.status.reason == ""


def test_while_the_will_runs_the_unit_is_off_and_says_why(tool: Tool) -> None:
    tool.grip_to(1)
    tool.owner.error = LineBusyError("the will of grip is being executed.")
    tool.unit.lost(OwnerError("the lease ended."))
    status = tool.until(lambda status: status.ee == State.OFF and bool(status.alarms))
    assert "the will of grip is being executed." in status.alarms
    assert not tool.unit.command("grip").accepted
    tool.owner.error = None
    overtake(tool)
    assert tool.until(lambda status: status.ee == State.STAND_BY).alarms == ()


def test_lines_that_did_not_move_change_nothing(tool: Tool) -> None:
    tool.grip_to(2)
    tool.unit.lost(OwnerError("the line owner was lost."))
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    assert State.OFF not in tool.states()[1:]
    assert tool.owner.will == ()


def test_gripped_is_not_claimed_before_the_owner_has_the_will_that_holds(tool: Tool) -> None:
    """Else it might unwind, with the will from before, what is held already."""
    tool.grip_to(2)
    assert tool.owner.will
    tool.owner.error = OwnerError("the line owner does not answer.")
    tool.confirmed[TOP] = ON
    tool.until(lambda status: any("does not answer" in alarm for alarm in status.alarms))
    for _ in range(30):
        tool.frame()
        threading.Event().wait(0.01)
    assert State.GRIPPED not in tool.states()
    tool.owner.error = None
    status = tool.until(lambda status: status.ee == State.GRIPPED)
    assert tool.owner.will == ()
    assert status.alarms == ()


def test_what_is_held_stays_held_while_there_is_no_owner(tool: Tool) -> None:
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    tool.owner.error = OwnerError("the line owner cannot be reached.")
    tool.unit.lost(OwnerError("the line owner was lost."))
    assert tool.until(lambda status: bool(status.alarms)).held
    tool.owner.error = None
    assert tool.until(lambda status: not status.alarms).ee == State.GRIPPED
    assert tool.states()[-1] == State.GRIPPED
    assert State.OFF not in tool.states()[1:]


def test_a_deactivation_that_found_no_owner_is_done_when_it_is_back(tool: Tool) -> None:
    tool.grip_to(1)
    tool.owner.error = OwnerError("the line owner cannot be reached.")
    assert tool.unit.command("cancel").accepted
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.until(lambda status: bool(status.alarms))
    assert tool.owner.active[BOTTOM]
    tool.owner.error = None
    tool.until(lambda status: status.ee == State.STAND_BY and not status.alarms)
    assert tool.owner.active == dict.fromkeys(LINES, OFF)


def test_maintenance_that_ends_without_an_owner_ends_nothing_else(
    tool: Tool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("end_effector_hal.tool._maintenance.LEASE_US", 100_000)
    tool.until(lambda status: status.ee == State.STAND_BY)
    threading.Thread(target=tool.unit.set_actuator, args=("cylinder", True, 0.01)).start()
    tool.until(lambda _: tool.owner.active[CYLINDER])
    tool.owner.error = OwnerError("the line owner cannot be reached.")
    tool.until(lambda status: any("cannot be reached" in alarm for alarm in status.alarms))
    assert tool.unit.alive
    tool.owner.error = None
    tool.until(lambda status: not status.alarms and not tool.owner.active[CYLINDER])


def test_a_frame_that_waited_too_long_proves_nothing(tool: Tool) -> None:
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    for _ in range(5):
        tool.frame(age_us=200_000)
    assert not tool.unit.wait(lambda status: status.ee == State.GRIPPED, 0.3)
    tool.until(lambda status: status.ee == State.GRIPPED)
