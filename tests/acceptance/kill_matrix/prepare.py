"""Brings a running system into the state of a cell, by the testbench's faults and ordinary goals."""

from __future__ import annotations

import time
from collections.abc import Callable

from end_effector_hal.vocabulary import ChangerState
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_lab.processes import Child
from tests.acceptance.kill_matrix.cells import GRIPPED, GRIPPING, RELEASING, STAND_BY, UNLOCKING, Cell
from tests.acceptance.kill_matrix.system import System
from tests.acceptance.kill_matrix.waiting import Late, until

GONE = 1


class Prepared:
    """A state was reached; ``goal`` still runs (None: no goal runs, or it is the Supervisor's)."""

    def __init__(self, goal: int | None = None, supervisor: Child | None = None) -> None:
        self.goal, self.supervisor = goal, supervisor


def at_rest(system: System) -> None:
    """STAND_BY, locked, nothing there, nothing wrong."""
    system.plant.choose("nominal")
    until("the whole system", system.is_up)
    state = until("an end of what runs", lambda: system.hands.look()["command"] == -1 and system.hands.state)
    if state["state"] != State.STAND_BY:
        system.hands.run("drop")
    if system.description.tool_changer is not None:
        until("a locked tool", lambda: system.hands.look()["tool_changer"] >= ChangerState.LOCKED)
        if system.hands.state["tool_changer"] != ChangerState.LOCKED:
            system.hands.run("lock")
    until("rest", lambda: _rests(system))


def _rests(system: System) -> bool:
    state = system.hands.look()
    clear = all(evidence == GONE for evidence in state["evidence"])
    locked = system.description.tool_changer is None or state["tool_changer"] == ChangerState.LOCKED
    return clear and locked and state["state"] == State.STAND_BY


def prepare(system: System, cell: Cell) -> Prepared:
    """Be in the state of the cell; raises Late."""
    at_rest(system)
    hands, description = system.hands, system.description
    supervisor = None
    if cell.process == "Supervisor":
        supervisor = system.supervisor()
        supervisor.wait_until(lambda: "commands:" in supervisor.text(), timeout_s=20.0, what="its prompt")

    def give(name: str) -> int | None:
        if supervisor is None:
            return hands.send(name)
        supervisor.tell(name)
        return None

    changer = description.tool_changer
    goal = None
    if cell.state == STAND_BY:
        return Prepared(None, supervisor)
    if cell.state.startswith(GRIPPING):
        system.plant.choose(f"never-confirms:{cell.step}")
        goal = give("grip")
        _reach(
            system, State.GRIPPING, _at_step(system, cell.step), description.actuators[cell.step].line, True
        )
    elif cell.state == UNLOCKING:
        assert changer is not None
        system.plant.choose("never-confirms:tool_changer")
        time.sleep(changer.vented_s + 0.2)  # IL-01: an unlock before that is refused
        goal = give("unlock")
        unlocking = lambda: hands.state["tool_changer"] == ChangerState.UNLOCKING  # noqa: E731
        _reach(system, State.STAND_BY, unlocking, changer.line, True)
    elif cell.state in (GRIPPED, RELEASING):
        first = description.releasing[0]
        if cell.state == RELEASING:
            system.plant.choose(f"stuck-release:{first}")
        give("grip")
        until("GRIPPED", lambda: hands.look()["state"] == State.GRIPPED and hands.state["command"] == -1)
        if cell.state == RELEASING:
            goal = give("drop")
            line = description.actuators[first].line
            _reach(system, State.RELEASING, lambda: True, line, False)
    return Prepared(goal, supervisor)


def _at_step(system: System, name: str) -> Callable[[], bool]:
    return lambda: system.hands.state["actuator"] == name


def _reach(system: System, state: State, more: Callable[[], bool], line: str, level: bool) -> None:
    def reached() -> bool:
        now = system.hands.look()["state"]
        return now == state and more() and (line in system.observer.active()) == level

    try:
        until(state.name, reached, 10.0)
    except Late:
        raise Late(f"{state.name} was not reached: {system.hands.state}") from None
