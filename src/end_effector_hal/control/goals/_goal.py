"""A goal: its command, its progress, and its ending."""

from __future__ import annotations

from dataclasses import dataclass, field
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
"""The channel of the automata to which each command is sent."""
GOAL_COMMANDS = (Command.GRIP, Command.RELEASE, Command.LOCK, Command.UNLOCK)
"""The commands that take time until they end, so that they can be goals."""


class Outcome(IntEnum):
    """The outcome of a goal. Zero, the default of any message, claims nothing."""

    NOT_EXECUTED = 0
    """The goal was cancelled before it was begun."""
    REJECTED = 1
    """The goal was refused, and not begun."""
    CANCELLED = 2
    """The goal was begun and cancelled; its outputs were released or kept, as the description declares."""
    FAILED = 3
    """The goal was begun, and ended in a defined failure."""
    UNREACHABLE = 4
    """The end of the goal is not known; if it was never accepted, not even whether it was begun."""
    SUCCEEDED = 5
    """The sensors prove the result."""


@dataclass(frozen=True, slots=True)
class Ending:
    """The ending of a goal.

    Attributes:
        outcome: the outcome.
        reason: the reason as a sentence; empty only for a success.
        seconds: time from the arrival of the goal to its end, s; None: it was not begun, as far as is known.
    """

    outcome: Outcome
    reason: str
    seconds: float | None = None


class Phase(Enum):
    """The progress of a goal."""

    WAITING = auto()
    """Another goal must be decided first."""
    ASKED = auto()
    """The program was asked to begin the goal, and has not answered yet."""
    RUNNING = auto()
    ENDED = auto()


@dataclass(slots=True, eq=False)
class Goal:
    """A goal and its place in the order of all goals; only `Goals` changes it.

    Attributes:
        command: GRIP, RELEASE, LOCK or UNLOCK.
        name: the client's name for the goal, for sentences.
        is_target: whether the goal is a position, which may be reached already.
        part: name of the part that a grip is for; empty: the default one.
    """

    command: Command
    name: str
    is_target: bool = False
    part: str = field(default="", kw_only=True)
    phase: Phase = Phase.WAITING
    ending: Ending | None = None
    cancelled: bool = False
    came_us: int = 0
    asked_us: int = 0
    session: int = 0
    """Start of its program as known when the goal was sent to it, µs; 0: not known."""
    count: int = 0
    """Number of the first status that is certain to follow the acceptance."""


class Effect(Enum):
    """An action that the caller must do after a decision."""

    ASK = auto()
    """Ask the program of the goal to begin the goal, then call `Goals.answer`."""
    GIVE_UP = auto()
    """Ignore a later answer: the program did not answer in time."""
    REPORT_BEGIN = auto()
    CANCEL = auto()
    """Ask the program to cancel its command; the program decides whether it does."""
    REPORT_PROGRESS = auto()
    REPORT_END = auto()
    """Send ``goal.ending`` to the client."""


GoalT = TypeVar("GoalT", bound=Goal)
GoalEffect = tuple[Effect, GoalT]
