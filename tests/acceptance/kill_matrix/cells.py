"""The cells of the matrix: who is hit, by what, in which state."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from end_effector_hal.description import Description

BOTH = "HAL and LineArbiter"
"""Both at once."""
NODES = ("HALMain", "Grip", "ToolChange", "Pressure", "Position")
PROCESSES = {
    "1": (*NODES, "LineArbiter", "roscore", "testbench", "Supervisor"),
    "2-five": (*NODES, "LineArbiter", "testbench", "Supervisor"),
    "2-one": ("HAL", "LineArbiter", "testbench", "Supervisor"),
    "none": ("HAL", "LineArbiter", BOTH, "testbench"),
}
"""The generations of ROS, the second with a process for each node and with one for all, to what may be hit; `none` is
one process without ROS."""
SIGNALS = ("SIGKILL", "SIGSTOP", "SIGTERM")
STOPPED_S = 3.0
"""A process that gets SIGSTOP goes on after this (SIGCONT)."""

STAND_BY, GRIPPING, GRIPPED, RELEASING, UNLOCKING = (
    "STAND_BY",
    "GRIPPING",
    "GRIPPED",
    "RELEASING",
    "unlocking",
)


@dataclass(frozen=True, order=True)
class Cell:
    """One cell; ``state`` is ``GRIPPING <actuator>`` for a step of the grip."""

    process: str
    signal: str
    state: str

    @property
    def number(self) -> signal.Signals:
        """Of the signal."""
        return signal.Signals[self.signal]

    @property
    def step(self) -> str:
        """The actuator that is pending; empty: none is."""
        return self.state.partition(" ")[2]

    @property
    def ends(self) -> bool:
        """Whether the process is not the same afterwards."""
        return self.signal != "SIGSTOP"

    def __str__(self) -> str:
        return f"{self.process}:{self.signal}:{self.state}"


def gripping(description: Description, part: str) -> Description:
    """The tool as it grips a part: with the actuators and the values of that part only."""
    used = zip(description.sequence, description.uses(part), strict=True)
    sequence = tuple(name for name, uses in used if uses)
    own = description.for_part(part)
    actuators = {name: own.actuators[name] for name in sequence}
    return own.model_copy(update={"sequence": sequence, "actuators": actuators}) if part else description


def states(description: Description) -> tuple[str, ...]:
    """In the order of a run; each step of the grip is one."""
    steps = (f"{GRIPPING} {name}" for name in description.sequence)
    return (STAND_BY, *steps, GRIPPED, RELEASING, *((UNLOCKING,) if description.tool_changer else ()))


def full(description: Description, generation: str) -> Iterator[Cell]:
    """Every cell."""
    for process in PROCESSES[generation]:
        for name in SIGNALS:
            for state in states(description):
                yield Cell(process, name, state)


def telling(description: Description, generation: str) -> Iterator[Cell]:
    """Those that say most in few minutes; `FIRST` and `LAST` are steps of the grip."""
    steps = [f"{GRIPPING} {name}" for name in description.sequence]
    named = {FIRST: steps[0], LAST: steps[-1]}
    wanted = {
        (process, each, named.get(state, state))
        for process, signals, states in TELLING
        for each in signals
        for state in states
    }
    return (cell for cell in full(description, generation) if parts(cell) in wanted)


FIRST, LAST = "first step", "last step"
KILL, STOP = SIGNALS[:1], SIGNALS[1:2]
TELLING = (
    ("HAL", SIGNALS, (FIRST, LAST, GRIPPED, RELEASING)),
    ("HAL", KILL, (STAND_BY, UNLOCKING)),
    ("HAL", STOP, (UNLOCKING,)),
    ("HALMain", SIGNALS, (FIRST, LAST, GRIPPED, RELEASING, UNLOCKING)),
    ("HALMain", STOP, (STAND_BY,)),
    ("Grip", SIGNALS, (GRIPPED,)),
    ("Grip", KILL, (LAST, RELEASING)),
    ("ToolChange", KILL, (GRIPPED, UNLOCKING)),
    ("Pressure", SIGNALS, (GRIPPED,)),
    ("Pressure", KILL, (LAST,)),
    ("Pressure", STOP, (RELEASING,)),
    ("Position", KILL, (GRIPPED,)),
    ("LineArbiter", SIGNALS, (LAST, GRIPPED, RELEASING)),
    ("LineArbiter", KILL, (STAND_BY, FIRST, UNLOCKING)),
    ("LineArbiter", STOP, (FIRST, UNLOCKING)),
    (BOTH, KILL, (LAST, GRIPPED, RELEASING, UNLOCKING)),
    ("roscore", SIGNALS, (GRIPPED,)),
    ("roscore", KILL, (LAST,)),
    ("testbench", SIGNALS, (GRIPPED,)),
    ("testbench", STOP, (LAST,)),
    ("Supervisor", KILL, (LAST, GRIPPED)),
)
"""Process, signals, states."""


def chosen(texts: Iterable[str], description: Description, generation: str) -> list[Cell]:
    """Cells whose parts begin as those of a text ``process:signal:state`` do; a part may be left out."""
    wanted = [text.lower().split(":") for text in texts]

    def fits(cell: Cell, begin: list[str]) -> bool:
        pairs = zip(parts(cell), begin, strict=False)
        return all(mine.lower().startswith(part.strip()) for mine, part in pairs)

    return [cell for cell in full(description, generation) if any(fits(cell, begin) for begin in wanted)]


def parts(cell: Cell) -> tuple[str, str, str]:
    """As they stand in the table."""
    return cell.process, cell.signal, cell.state
