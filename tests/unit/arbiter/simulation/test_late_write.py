"""A Drop and a cancel at every message of a lost line arbiter: after their result nothing is written."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import count

import pytest

from end_effector_hal.vocabulary import EndEffectorState
from tests.unit.arbiter.simulation.world import GRIP_LINES, World, virtual_time

DOWN_US = 12_000_000
"""Longer than a whole release: a command that is at work when the arbiter dies has its result before it is back."""
ORDERS = ("the program lives", "the arbiter starts first", "the program starts first")
WAITS = (0, 1, 4, 8, 40)
"""Ticks from the death to the command: not noticed yet, being noticed, noticed."""

RECORDED = ("arbiter dies", "set: before a reply")
"""The record has the last will of a release that has begun, and the program has no answer. If the program dies as well
before the arbiter is back, that last will is carried out, as it is when a program dies in a release."""


class Lost:
    """A world whose arbiter dies at one point of a message.

    Args:
        world: nothing has happened in it yet.
        command: ``drop``, given in GRIPPED, or ``cancel``, in the last step of a grip.
    """

    def __init__(self, world: World, command: str) -> None:
        self.world, self.command = world, command
        world._faults, world.never_confirms = [], GRIP_LINES[-1] if command == "cancel" else None
        world._start_arbiter()
        self.tick(lambda: self.state == EndEffectorState.STAND_BY)
        self.tick(lambda: bool(world.program and world.program.command("grip")))
        if command == "drop":
            self.tick(lambda: self.state == EndEffectorState.GRIPPED)
        else:
            self.tick(lambda: all(world.lines[name] for name in GRIP_LINES))
        for _ in range(10):
            world._tick()

    @property
    def state(self) -> int:
        return self.world.program.state if self.world.program else -1

    def tick(self, until: Callable[[], bool]) -> None:
        for _ in range(1_000):
            if until():
                return
            self.world._tick()
        raise AssertionError(self.world.judge.violations or self.world.program)

    def give(self) -> bool:
        program = self.world.program
        assert program is not None
        return bool(self.world._as_program(lambda: program.command(self.command)))

    def die_at(self, point: int) -> None:
        self.world._faults = [(self.world._points + point, "arbiter dies")]

    def come_back(self, order: str) -> None:
        """The arbiter is away for a while; the programs are started again as ``order`` says."""
        world = self.world
        back = world._heal_at["arbiter"] = world.now + DOWN_US
        if order == "the program starts first":
            self.end_program(world.now + DOWN_US // 2)
        self.tick(lambda: world.now >= back)
        for _ in range(60):
            world._tick()
        if order == "the arbiter starts first":
            self.end_program(world.now)
        self.tick(lambda: world.program is not None)

    def end_program(self, at: int) -> None:
        self.tick(lambda: self.world.now >= at)
        self.world._doomed.add("program")
        self.world._bury()

    def judged(self) -> list[str]:
        """Everything works again; a new Drop releases what is held."""
        if not self.world.judge.violations:
            self.world._must_work()
        return self.world.judge.violations


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("command", ["drop", "cancel"])
def test_a_command_to_a_lost_arbiter_ends_unreachable_and_changes_nothing(command: str, order: str) -> None:
    with pytest.MonkeyPatch.context() as patch, virtual_time(patch) as enter:
        for waits in WAITS:
            enter(world := World(1, Counter()))
            lost = Lost(world, command)
            world._bury_arbiter()
            world._heal_at["arbiter"] = world.now + DOWN_US
            for _ in range(waits):
                world._tick()
            before, program = dict(world.lines), world.program
            assert not lost.give(), waits
            assert program is not None
            assert program.told is not None
            if waits >= WAITS[2]:
                assert program.told.arbiter_lost
                assert all(program.told.outputs)
                assert program.told.held is (command == "drop")
            lost.come_back(order)
            if command == "drop":
                assert world.lines == before, waits
                lost.tick(lambda lost=lost: lost.state == EndEffectorState.GRIPPED)  # type: ignore[misc]
            assert lost.judged() == [], waits


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("command", ["drop", "cancel"])
def test_an_arbiter_that_dies_at_any_message_of_a_command_writes_nothing_after_its_result(
    command: str, order: str
) -> None:
    with pytest.MonkeyPatch.context() as patch, virtual_time(patch) as enter:
        for point in count(1):
            enter(world := World(1, Counter()))
            lost = Lost(world, command)
            lost.die_at(point)
            lost.give()
            while world.arbiter is not None and lost.state != EndEffectorState.STAND_BY:
                world._tick()
            if world.arbiter is not None:
                break
            lost.come_back(order)
            if (order, *world._met) == (ORDERS[2], RECORDED):
                continue
            assert lost.judged() == [], point
        assert point > 20
