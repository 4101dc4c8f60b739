"""What became of a command, read off the status of the unit that executed it."""

from __future__ import annotations

from typing import Any

from end_effector_msgs.msg import Cause, Outcome, State

from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState

_WANTED = {
    Command.GRIP: State.GRIPPED,
    Command.RELEASE: State.STAND_BY,
    Command.LOCK: ChangerState.LOCKED,
    Command.UNLOCK: ChangerState.UNLOCKED,
}


def is_over(status: Any) -> bool:
    """Whether a unit that had accepted a command executes it no more."""
    return bool(status.command == Command.NONE)


def judge(command: Command, status: Any) -> tuple[int, str]:
    """Outcome, and the reason in words; the sensors have decided it, this only says so."""
    wanted = _WANTED[command]
    if command in (Command.LOCK, Command.UNLOCK):
        if status.tool_changer == wanted:
            return Outcome.SUCCEEDED, ""
        reached, name = ChangerState(status.tool_changer).name, ChangerState(wanted).name
        why = f"The tool changer is {reached}: its sensors do not prove {name}. {status.reason}"
        return Outcome.FAILED, why.rstrip()
    if status.state == wanted:
        return Outcome.SUCCEEDED, ""
    cancelled = command is Command.GRIP and status.cause == Cause.CANCELLED
    reason = status.reason or f"The end-effector is {EndEffectorState(status.state).name}."
    return (Outcome.CANCELLED if cancelled else Outcome.FAILED), reason
