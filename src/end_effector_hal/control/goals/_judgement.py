"""What became of a command, read from the status of the program that executed it."""

from __future__ import annotations

from end_effector_hal.vocabulary import Cause, ChangerState, Command, EndEffectorState, Evidence

from .._status import Status
from ._goal import Outcome

_WANTED_STATES = {Command.GRIP: EndEffectorState.GRIPPED, Command.RELEASE: EndEffectorState.STAND_BY}
_LOST = "The line arbiter is lost: the outputs are not known."
_WANTED_POSITIONS = {Command.LOCK: ChangerState.LOCKED, Command.UNLOCK: ChangerState.UNLOCKED}
_WANTED_EVIDENCE = {Command.GRIP: Evidence.CONFIRMED, Command.RELEASE: Evidence.GONE}


def is_over(status: Status) -> bool:
    """Whether a program that had accepted a command does not execute it any more."""
    return status.command == Command.NONE


def is_reached(command: Command, status: Status) -> bool:
    """Whether a grip or a release asks for what every sensor proves already, while nothing else is executed."""
    wanted = all(evidence is _WANTED_EVIDENCE[command] for evidence in status.evidence)
    return wanted and is_over(status) and status.ee == _WANTED_STATES[command]


def judge(command: Command, status: Status) -> tuple[Outcome, str]:
    """The outcome of a command that is over, and the reason in words; the sensors have decided it.

    While the line arbiter is lost only what the sensors prove is known.
    """
    if command in _WANTED_POSITIONS:
        reached, position = status.changer, _WANTED_POSITIONS[command]
        if reached is position:
            return Outcome.SUCCEEDED, ""
        if status.arbiter_lost:
            return Outcome.UNREACHABLE, status.reason or _LOST
        why = f"The tool changer is {reached.name}: its sensors do not prove {position.name}."
        return Outcome.FAILED, f"{why} {status.reason}".rstrip()
    if status.ee == _WANTED_STATES[command]:
        return Outcome.SUCCEEDED, ""
    if status.arbiter_lost and status.ee != EndEffectorState.STAND_BY:
        return Outcome.UNREACHABLE, status.reason or _LOST
    cancelled = command is Command.GRIP and status.cause == Cause.CANCELLED
    reason = status.reason or f"The end-effector is {status.ee.name}."
    return (Outcome.CANCELLED if cancelled else Outcome.FAILED), reason
