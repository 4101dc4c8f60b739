"""A program that restarts by itself, because the line arbiter died during a write: what was latched stays latched."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import WireError
from end_effector_hal.runtime.programs._program import CAME_LATE, UNWRITTEN
from end_effector_hal.vocabulary import (
    NO_PART,
    ChangerFault,
    ChangerState,
    EndEffectorState,
    LastWillStep,
    WrittenPart,
)
from end_effector_lab.virtual import VirtualTool
from tests.unit.virtual.test_tool import (
    BOTTOM,
    CYLINDER,
    TOP,
    UNLOCK,
    gripped,
    moved,
    pending_cylinder,
    started_with_a_slow_disk,
    until,
)

GRIP_ERROR, GRIPPED, GRIPPING, OFF, STAND_BY = (
    EndEffectorState.GRIP_ERROR,
    EndEffectorState.GRIPPED,
    EndEffectorState.GRIPPING,
    EndEffectorState.OFF,
    EndEffectorState.STAND_BY,
)


def without_locks() -> Description:
    """The shipped tool, which may be unlocked while it holds a part."""
    shipped = load(profile_path())
    return shipped.model_copy(
        update={"interlocks": shipped.interlocks.model_copy(update={"il_01": False, "il_05": False})}
    )


def dies_in_next_write(tool: VirtualTool, *, executed: bool) -> None:
    """The line arbiter dies before or after it executes the next write; its reply is lost in either case."""
    connection = tool._connection
    assert connection
    ask = connection.ask

    def dying(
        levels: dict[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        connection.ask = ask  # type: ignore[method-assign]
        if executed:
            ask(levels, will, drop=drop, part=part)
        tool.kill("arbiter")
        return ask(levels, will, drop=drop, part=part)

    connection.ask = dying  # type: ignore[method-assign, assignment]


def lose(tool: VirtualTool) -> None:
    """The part is lost for a moment; then all sensors confirm again."""
    tool.choose("shows:top_vacuum:0")
    until(tool, GRIP_ERROR)
    tool.choose("nominal")
    tool.run(0.5)
    assert (tool.status.ee, tool.status.lift_allowed) == (GRIP_ERROR, False)


def released(tool: VirtualTool, since: int) -> list[str]:
    return [line for line, level in moved(tool, since) if not level]


@pytest.mark.parametrize("executed", [False, True])
@pytest.mark.parametrize("word", ["lock", "unlock"])
def test_a_lock_that_is_not_written_neither_drops_a_part_nor_forgets_its_loss(
    word: str, executed: bool
) -> None:
    tool = gripped(description=without_locks())
    if word == "lock":
        assert tool.command("unlock").accepted
        tool.run(0.3)
        assert tool.status.changer == ChangerState.UNLOCKED
    lose(tool)
    before, told = len(tool.edges), len(tool.statuses)
    dies_in_next_write(tool, executed=executed)
    answer = tool.command(word)
    # an unlock is not given up before its time is over
    assert (answer.accepted, answer.reason) == ((False, UNWRITTEN) if word == "lock" else (True, ""))
    tool.run(5.0)
    assert (tool.status.ee, tool.status.held, tool.status.outputs) == (OFF, True, (True, True, True))
    assert tool.status.arbiter_lost
    tool.start("arbiter")
    until(tool, GRIP_ERROR)
    tool.run(4.0)
    assert {status.ee for status in tool.statuses[told:]} == {GRIP_ERROR, OFF}
    assert all(status.held for status in tool.statuses[told:])
    assert set(released(tool, before)) <= {UNLOCK}
    assert not tool.levels[UNLOCK]
    assert tool.status.reason == "GRIP_ERROR was latched before the program restarted."
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert released(tool, before)[-3:] == [TOP, CYLINDER, BOTTOM]


@pytest.mark.parametrize("executed", [False, True])
def test_a_drop_of_a_lost_part_that_is_not_written_leaves_the_error(executed: bool) -> None:
    tool = gripped()
    lose(tool)
    before, told = len(tool.edges), len(tool.statuses)
    dies_in_next_write(tool, executed=executed)
    assert not tool.command("drop").accepted
    tool.start("arbiter")
    until(tool, GRIP_ERROR)
    tool.run(3.0)
    assert {status.ee for status in tool.statuses[told:]} == {GRIP_ERROR, OFF}
    assert released(tool, before) == ([TOP] if executed else [])
    assert tool.status.outputs == (True, True, not executed)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)


def test_an_error_outlasts_several_restarts_before_the_lines_are_adopted() -> None:
    tool = gripped()
    lose(tool)
    dies_in_next_write(tool, executed=False)
    assert not tool.command("drop").accepted
    assert tool._program
    tool._program._act(tool._program._restart("Another reason."))
    tool.start("arbiter")
    tool._program._act(tool._program._restart("And another one."))
    told = len(tool.statuses)
    until(tool, GRIP_ERROR)
    tool.run(3.0)
    assert {status.ee for status in tool.statuses[told:]} <= {GRIP_ERROR, OFF}
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    tool._program._act(tool._program._restart("A Drop has ended it."))
    until(tool, GRIPPED, 2.0)


@pytest.mark.parametrize("executed", [False, True])
@pytest.mark.parametrize("word", ["lock", "drop"])
def test_a_release_that_failed_activates_nothing_after_a_restart(word: str, executed: bool) -> None:
    tool = gripped("stuck-release:bottom_vacuum", without_locks())
    assert tool.command("drop").accepted
    until(tool, EndEffectorState.RELEASE_ERROR)
    if word == "lock":
        assert tool.command("unlock").accepted
        tool.run(0.3)
    before = len(tool.edges)
    dies_in_next_write(tool, executed=executed)
    assert not tool.command(word).accepted
    tool.start("arbiter")
    tool.run(4.0)
    assert set(moved(tool, before)) <= {(UNLOCK, False)}
    assert not any(tool.levels.values())
    assert tool.status.ee == STAND_BY
    answer = tool.command("grip")
    assert answer.reason.startswith("IL-07"), "the feedback that stayed still refuses it"
    tool.choose("nominal")
    tool.run(2.0)
    assert tool.command("grip").accepted


@pytest.mark.parametrize("moment", ["lost", "gripping", "releasing"])
def test_a_sensor_fault_that_comes_late_holds_what_is_active(moment: str) -> None:
    """The whole program restarts for the tool changer's fault: that neither releases nor confirms anything."""
    tool = started_with_a_slow_disk()
    assert tool.command("grip").accepted
    if moment == "gripping":
        assert tool.run_until(tool.at + 10_000_000, lambda: tool.levels[CYLINDER])
    else:
        until(tool, GRIPPED)
    if moment == "lost":
        lose(tool)
    elif moment == "releasing":
        assert tool.command("drop").accepted
    told = len(tool.statuses)
    tool.memories.journal.hangs = False
    assert tool.run_until(tool.at + 2_000_000, lambda: CAME_LATE in tool.status.reason)
    before, active = len(tool.edges), tuple(tool.levels[line] for line in (BOTTOM, CYLINDER, TOP))
    tool.run(5.0)
    assert moved(tool, before) == []
    assert (tool.status.ee, tool.status.held, tool.status.outputs) == (GRIP_ERROR, True, active)
    assert GRIPPED not in {status.ee for status in tool.statuses[told:]}
    assert tool.status.changer_fault == ChangerFault.SENSOR
    assert tool.command("drop").accepted
    until(tool, STAND_BY)


class StuckOutputs:
    """Outputs of which some cannot be deactivated."""

    def __init__(self, tool: VirtualTool, *lines: str) -> None:
        self.lines, self._set = set(lines), tool._outputs.set
        tool._outputs.set = self.set  # type: ignore[method-assign]

    def set(self, levels: Mapping[str, bool]) -> None:
        if stuck := [line for line, level in levels.items() if line in self.lines and not level]:
            raise WireError(f"{stuck[0]} cannot be written.")
        self._set(levels)


STUCK = "the last will of hal cannot be executed: SODIMM_210 (cylinder) cannot be deactivated"


@pytest.mark.parametrize("dies", [False, True])
def test_a_last_will_that_is_stuck_is_waited_for_and_its_outputs_are_told_as_active(dies: bool) -> None:
    """The program was declared dead in a grip, or has died: its lines are its own again once the will is done."""
    tool = pending_cylinder()
    stuck, before, told = StuckOutputs(tool, CYLINDER), len(tool.edges), len(tool.statuses)
    arbiter, connection = tool._arbiters.now, tool._connection
    assert arbiter
    assert connection
    assert connection._session
    if dies:
        tool.kill("hal")
        tool.start("hal")
    else:
        arbiter.rules.declare_dead(connection._session, "its connection was lost", tool.at)
        arbiter.keep()
    for _ in range(10):
        tool.run(0.5)
        assert tool.status.ee == OFF
        assert tool.status.outputs == (True, True, False)
        assert [tool.levels[line] for line in (BOTTOM, CYLINDER, TOP)] == [True, True, False]
        if not dies:
            assert any(STUCK in alarm for alarm in tool.status.alarm_texts)
            assert not tool.command("grip").accepted
            assert not tool.command("drop").accepted
    assert ("hal" in tool.living) is not dies
    stuck.lines.clear()
    tool.run(3.0)
    assert moved(tool, before) == [(CYLINDER, False), (BOTTOM, False)]
    assert {status.ee for status in tool.statuses[told:]} <= {OFF, GRIPPING, STAND_BY}
    assert tool.status.ee == STAND_BY
    assert tool.status.outputs == (False, False, False)
    assert tool.reset().accepted
    tool.run(1.0)
    assert tool.command("grip").accepted
    until(tool, GRIPPED)


def test_a_command_before_the_lines_are_adopted_is_refused_and_not_executed_later() -> None:
    tool = gripped()
    tool.kill("hal")
    tool.run(0.4)
    before = len(tool.edges)
    tool.start("hal")
    assert (tool.status.ee, tool.status.adopted) == (OFF, False)
    program = tool._program
    assert program
    for word in ("grip", "drop", "cancel", "resume", "lock", "unlock", "arm", "reset"):
        answer = program.command(word)
        assert (answer.accepted, bool(answer.reason)) == (False, True), word
    for active in (True, False):
        assert program._drive("cylinder", None, active=active).reason.startswith("IL-12: a part is held")
    assert program.stand_still().reason.startswith("A part is held, or may be: drop it first.")
    until(tool, GRIPPED)
    tool.run(3.0)
    assert moved(tool, before) == []
    assert (tool.status.changer, tool.status.lift_allowed) == (ChangerState.LOCKED, True)


def test_deaths_in_a_row_drop_nothing_and_leave_a_will_that_is_executed() -> None:
    """Each at another distance from the one before: within an adoption, a lease, a write of the program that starts."""
    held, gripping = gripped(), pending_cylinder()
    before = [len(tool.edges) for tool in (held, gripping)]
    for tool in (held, gripping):
        for number in range(6):
            tool.kill("arbiter")
            tool.run(0.003 * number)
            tool.kill("hal")
            tool.run(0.1 * number)
            tool.start("arbiter")
            tool.run(0.01 * number)
            tool.start("hal")
            tool.run(0.03 * number)
            tool.kill("hal")
            tool.run(0.02)
            tool.start("hal")
            tool.run(0.02 * number)
        tool.run(8.0)
        assert tool.living == {"arbiter", "hal"}
    assert moved(held, before[0]) == []
    assert (held.status.ee, held.status.lift_allowed) == (GRIPPED, True)
    assert moved(gripping, before[1]) == [(CYLINDER, False), (BOTTOM, False)]
    assert gripping.status.ee == STAND_BY


def test_no_description_is_taken_over_while_a_last_will_is_executed() -> None:
    tool = pending_cylinder()
    arbiter, connection, program = tool._arbiters.now, tool._connection, tool._program
    assert arbiter
    assert connection
    assert connection._session
    assert program
    arbiter.rules.declare_dead(connection._session, "its connection was lost", tool.at)
    arbiter.keep()
    tool.run(0.5)
    assert [tool.levels[line] for line in (BOTTOM, CYLINDER)] == [True, False]
    assert program.stand_still().reason.startswith(
        "The lines are not adopted yet. the last will of hal is being executed."
    )
    until(tool, STAND_BY, 3.0)
    assert not any(tool.levels.values())
    assert program.stand_still().accepted
