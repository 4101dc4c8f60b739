"""A script: commands of Table II in words, one after the other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import Command

VERBS: Mapping[str, Command] = {
    "lock": Command.LOCK,
    "unlock": Command.UNLOCK,
    "grip": Command.GRIP,
    "drop": Command.RELEASE,
    "release": Command.RELEASE,
    "cancel": Command.CANCEL,
    "quit": Command.QUIT,
    "exit": Command.QUIT,
}
ARM = "arm"
"""Arms an unlock (IL-02); Table II has no command for it."""
RESET = "reset"
"""Clears latched faults; Table II has no command for it."""
LONGEST_WAIT_S = 86_400.0


@dataclass(frozen=True)
class ScriptCommand:
    """One command; where ``command`` is None a reset, or else a wait.

    ``background``: the next one follows without waiting for the outcome, as after ``&`` in a shell.
    """

    command: Command | None = None
    wait_s: float = 0.0
    background: bool = False
    reset: bool = False
    arm: bool = False


def read_script(text: str) -> tuple[ScriptCommand, ...]:
    """Commands from text such as ``lock; grip &; wait 2; cancel; quit``; a line end separates as ``;`` does.

    Raises:
        UsageError: a step is no command; it says which, and what was perhaps meant.
    """
    lines = (line.partition("#")[0] for line in text.splitlines())
    parts = (part.strip() for line in lines for part in line.split(";"))
    return tuple(read_command(part) for part in parts if part)


def read_command(text: str) -> ScriptCommand:
    """One command; raises UsageError."""
    words = text.lower().removesuffix("&").split()
    background = text.rstrip().endswith("&")
    verb, *rest = words or [""]
    if verb == "wait":
        if background:
            raise UsageError(f"{text!r}: a wait cannot go on in the background.")
        return ScriptCommand(wait_s=_seconds(text, rest))
    if verb not in (*VERBS, ARM, RESET):
        close = get_close_matches(verb, [*VERBS, ARM, RESET, "wait"], n=1)
        known = f"There are: {', '.join(VERBS)}, {ARM}, {RESET}, wait <seconds>."
        todo = f"Did you mean {close[0]!r}?" if close else known
        raise UsageError(f"{verb or text!r} is no command.", todo=todo)
    if rest:
        raise UsageError(f"{text!r}: nothing may follow {verb!r}.", todo="Separate commands by ';'.")
    if verb == ARM:
        return ScriptCommand(arm=True)
    if verb == RESET:
        return ScriptCommand(reset=True)
    return ScriptCommand(VERBS[verb], background=background)


def _seconds(text: str, rest: list[str]) -> float:
    try:
        seconds = float(rest[0]) if len(rest) == 1 else math.nan
    except ValueError:
        seconds = math.nan
    if not 0 <= seconds <= LONGEST_WAIT_S:
        raise UsageError(f"{text!r}: expected is 'wait <seconds>', for example 'wait 2.5'.")
    return seconds
