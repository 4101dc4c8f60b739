"""What must be after a cell, from the description and the documented rules alone: nothing here was observed.

Rules:

* A program that dies (SIGKILL) gets the ending ``process_death``, one that is told to end ``sigterm``. One that
  hangs for longer than its lease (1 s) is dead to the line arbiter. Each actuator has its own ending: `release`
  unwinds in release order, `hold` and `leave` move nothing. While it is releasing, the release is carried out. The
  tool changer ends locked. What the program that starts anew finds active is released where ``power_up`` says so;
  what is left, if it is part of a grip alone, is a GRIP_ERROR.
* A line arbiter that dies moves nothing, and the program goes on when it is back. A release that ends before that
  writes nothing any more: what is left of it stays active, a latched GRIP_ERROR. One that hangs for longer than its
  clients wait for an answer (1 s) finds their connections closed: they are dead to it.
* The node HALMain runs the tool, sensors included; the one process of ROS 2, or without ROS (HAL), is all nodes at
  once. If the line arbiter dies with it, nothing moves until both are back; then the program gets its ending.
* Grip, ToolChange, Pressure and Position are faces: their death moves nothing, and the tool does not notice it.
* A master that goes away makes every node end in order, and start anew once it is back.
* Who owns no line moves none: what runs, goes on. What lacks readings meanwhile waits, holds, and confirms nothing;
  a release without readings may end in RELEASE_ERROR.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import ChangerState
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.acceptance.kill_matrix.cells import BOTH, GRIPPED, GRIPPING, RELEASING, UNLOCKING, Cell

Switch = tuple[str, bool]
"""A line and its new level."""
GOES_ON = "goes on"


@dataclass(frozen=True)
class Expected:
    """Everything that follows the signal, until nothing moves any more.

    Attributes:
        why: the rule.
        gripping, unlock: every change of those lines, in order; steps that are attempted again left out.
        active: lines that are active in the end.
        states: one of these, in the end.
        changers: and one of these, where there is a tool changer.
        first_s: the first movement comes at most so long after the signal; None: no matter.
        may_keep: whether a release may end before its lines can be written again.
    """

    why: str
    gripping: tuple[Switch, ...]
    unlock: tuple[Switch, ...]
    active: frozenset[str]
    states: frozenset[State]
    changers: frozenset[ChangerState]
    first_s: float | None = None
    may_keep: bool = False

    def kept(self, active: int) -> Expected:
        """The same where so many lines are left active by a release that ended without a line arbiter."""
        done = len(self.gripping) - active
        left = frozenset(line for line, _ in self.gripping[done:])
        return replace(self, gripping=self.gripping[:done], active=left, states=frozenset({State.GRIP_ERROR}))

    def text(self, names: dict[str, str]) -> str:
        """In words."""
        return f"{self.why}: {one_of(self.states)}; {told((*self.unlock, *self.gripping), names)}"


def expected(description: Description, cell: Cell) -> Expected:
    """The declared ending of a cell."""
    ending = _ending(cell)
    if cell.state == UNLOCKING:
        return _unlocking(description, cell, ending)
    lines = [actuator.line for _, actuator in description.ordered]
    releasing = [description.actuators[name].line for name in description.releasing]
    engaged: list[str] = []
    at_once = releasing
    why, moved, after = "nothing moves", (), {State.STAND_BY}
    if cell.state == GRIPPED:
        engaged, why, after = lines, "held", {State.GRIPPED}
        if ending != GOES_ON:
            at_once, later = _released(description, cell.state, ending, engaged)
            moved = _off([*at_once, *later])
            why = "released" if moved else why
            after = {_adopted(description, engaged, moved, State.GRIPPED)}
    elif cell.state == RELEASING:
        engaged, why, moved = releasing[1:], "release ends", _off(releasing[1:])
        if ending == GOES_ON and cell.process in ("testbench", "LineArbiter"):
            after = {State.STAND_BY, State.RELEASE_ERROR}
    elif cell.state.startswith(GRIPPING):
        engaged = lines[: description.sequence.index(cell.step) + 1]
        if ending == GOES_ON:
            why, after = "grip goes on", {State.GRIPPED}
            moved = tuple((line, True) for line in lines[len(engaged) :])
        else:
            at_once, later = _released(description, cell.state, ending, engaged)
            moved = _off([*at_once, *later])
            why = "unwound" if moved else "held"
            after = {_adopted(description, engaged, moved, State.GRIP_ERROR)}
            if len(engaged) == len(lines) and not moved:
                after = {State.GRIP_ERROR, State.GRIPPED}  # as the last one is confirmed by then, or not
    active = {line for line, level in (*((line, True) for line in engaged), *moved) if level}
    active -= {line for line, level in moved if not level}
    locked = frozenset({ChangerState.LOCKED})
    first_s = _first_s(cell) if ending != GOES_ON and moved and at_once else None
    may_keep = cell.state == RELEASING and cell.process == "LineArbiter" and ending == GOES_ON
    return Expected(why, moved, (), frozenset(active), frozenset(after), locked, first_s, may_keep)


def _released(
    description: Description, state: str, ending: str, engaged: list[str]
) -> tuple[list[str], list[str]]:
    """Lines that an ending releases, in release order; and those that the start after it releases."""
    at_once, later = [], []
    for name in description.releasing:
        line, its = description.actuators[name].line, description.endings_of(name)
        if line in engaged and getattr(its.held if state == GRIPPED else its.gripping, ending) == "release":
            at_once.append(line)
        elif line in engaged and its.power_up == "release":
            later.append(line)
    return at_once, later


def _adopted(description: Description, engaged: list[str], moved: tuple[Switch, ...], whole: State) -> State:
    """What is found, by the program that starts anew."""
    left = len(engaged) - len(moved)
    if not left:
        return State.STAND_BY
    return whole if left == len(description.sequence) else State.GRIP_ERROR


def _unlocking(description: Description, cell: Cell, ending: str) -> Expected:
    """Whatever ends: the unlock output goes inactive (IL-03 at the latest), the spring locks."""
    assert description.tool_changer is not None
    changers = {ChangerState.LOCKED}
    if ending != GOES_ON or cell.process in ("testbench", "LineArbiter"):
        # the lock may not be proven in time (IL-04), or adopted before it is
        changers |= {ChangerState.FAULT, ChangerState.UNKNOWN}
    off = ((description.tool_changer.line, False),)
    own = ending == GOES_ON or getattr(description.tool_changer.endings, ending) != "release"
    after, first_s = frozenset({State.STAND_BY}), None if own else _first_s(cell)  # else: IL-03 in its time
    return Expected("relocked", (), off, frozenset(), after, frozenset(changers), first_s)


def _ending(cell: Cell) -> str:
    """The key of the ending that the program gets, or that it goes on."""
    ending = "sigterm" if cell.signal == "SIGTERM" else "process_death"
    if cell.process == "LineArbiter" and cell.signal == "SIGSTOP":
        ending = "process_death"
    elif cell.process == "roscore" and cell.ends:
        ending = "sigterm"
    elif cell.process not in ("HALMain", "HAL", BOTH):
        return GOES_ON
    return ending


def _first_s(cell: Cell) -> float | None:
    """How long a will may wait: for a socket that closes, for an orderly end, or for the end of a lease."""
    if cell.process not in ("HALMain", "HAL"):
        return None
    return {"SIGKILL": 0.5, "SIGTERM": 1.5, "SIGSTOP": 1.0 + 0.5}[cell.signal]


def _off(lines: list[str]) -> tuple[Switch, ...]:
    return tuple((line, False) for line in lines)


def one_of(names: frozenset[State]) -> str:
    """Names, with "or" between them."""
    return " or ".join(name.name for name in sorted(names, reverse=True))


def told(switches: tuple[Switch, ...], names: dict[str, str]) -> str:
    """Changes of lines in words."""
    return (
        ", ".join(f"{names[line]} {'on' if level else 'off'}" for line, level in switches) or "no line moves"
    )
