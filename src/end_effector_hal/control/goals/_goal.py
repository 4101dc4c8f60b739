"""One goal: what is asked for, how far it is, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum, auto
from typing import TypeVar

from end_effector_hal.vocabulary import Command

CHANNELS = {
    Command.LOCK: "lock",
    Command.UNLOCK: "unlock",
    Command.GRIP: "grip",
    Command.RELEASE: "drop",
    Command.CANCEL: "cancel",
}
"""The channel of the automata that each command is sent on."""
PROGRAM_COMMANDS = {
    "grip": (Command.GRIP, Command.RELEASE, Command.CANCEL),
    "tool_change": (Command.LOCK, Command.UNLOCK),
}
"""The commands that each program executes."""
GOAL_COMMANDS = (Command.GRIP, Command.RELEASE, Command.LOCK, Command.UNLOCK)
"""The commands that have an end."""
_PROGRAM = {command: name for name, commands in PROGRAM_COMMANDS.items() for command in commands}


class Outcome(IntEnum):
    """How a goal ended. Zero, the default of any message, claims nothing."""

    NOT_EXECUTED = 0
    """It was cancelled before it was begun."""
    REJECTED = 1
    """It was refused, and not begun."""
    CANCELLED = 2
    """It was begun and cancelled; its outputs were released or kept, as the description declares."""
    FAILED = 3
    """It was begun, and ended in a defined failure."""
    UNREACHABLE = 4
    """Its end is not known; where it was never accepted, not even whether it was begun."""
    SUCCEEDED = 5
    """The sensors prove it."""


@dataclass(frozen=True, slots=True)
class Ending:
    """How a goal ended.

    Attributes:
        outcome: in one word.
        reason: in words; empty for a success only.
        seconds: from when the goal came to its end; None: it was not begun, as far as that is known.
    """

    outcome: Outcome
    reason: str
    seconds: float | None = None


class Phase(Enum):
    """How far a goal is."""

    WAITING = auto()
    """Another goal is to be decided before."""
    ASKED = auto()
    """Its program was asked to begin it, and has not answered yet."""
    RUNNING = auto()
    ENDED = auto()


@dataclass(slots=True, eq=False)
class Goal:
    """A goal and its place in the order of all goals; only `Goals` changes it.

    Attributes:
        command: GRIP, RELEASE, LOCK or UNLOCK.
        name: what its client calls it, for sentences.
        is_target: it asks for a position, which may be reached already.
    """

    command: Command
    name: str
    is_target: bool = False
    phase: Phase = Phase.WAITING
    ending: Ending | None = None
    cancelled: bool = False
    came_us: int = 0
    asked_us: int = 0
    session: int = 0
    """The start of its program when it was asked; 0: not known."""
    count: int = 0
    """The number of the first status that is certain to follow the acceptance."""

    @property
    def program(self) -> str:
        """The program that executes it: ``grip`` or ``tool_change``."""
        return _PROGRAM[self.command]


class Effect(Enum):
    """What the caller has to do after a decision."""

    ASK = auto()
    """Ask the program of the goal to begin it, then call `Goals.answer`."""
    GIVE_UP = auto()
    """The program did not answer in time: an answer that comes later does not count."""
    REPORT_BEGIN = auto()
    CANCEL = auto()
    """Ask the program to cancel what it executes; whether it does is its decision."""
    REPORT_PROGRESS = auto()
    REPORT_END = auto()
    """Give the client ``goal.ending``."""


GoalT = TypeVar("GoalT", bound=Goal)
GoalEffect = tuple[Effect, GoalT]
