"""Parse scripts: sequences of commands of Table II, written as words."""

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
"""Word that arms an unlock (IL-02); Table II has no command for it."""
RESUME = "resume"
"""Word that ends a GRIP_ERROR after a loss; Table II has no command for it."""
RESET = "reset"
"""Word that clears latched faults; Table II has no command for it."""
STOP = "stop"
"""Word that latches a stop (IL-13); Table II has no command for it."""
RELOAD = "reload"
"""Word that makes the session adopt the current content of the description file."""
SHOWN = ("status", "help")
"""Words that the session answers, not the tool."""
WAIT = "wait"
SET = "set"
"""Word that switches a plain output: ``set lamp on``."""
LEVELS = {"on": True, "off": False}
SCENARIO = "scenario"
"""Word that selects the scenario of a simulated tool from now on: ``scenario leak:top_vacuum``."""
WORDS = (*VERBS, RESUME, ARM, STOP, RESET, RELOAD, *SHOWN, SET, WAIT, SCENARIO)
LONGEST_WAIT_S = 86_400.0


@dataclass(frozen=True)
class ScriptCommand:
    """One step of a script.

    If ``command`` is None, the step is a resume, a stop, a reset, a reload, an arming, an output, something to show,
    a scenario, or else a wait.

    Attributes:
        background: whether the next step starts without waiting for the outcome, as after ``&`` in a shell.
        show: a word of `SHOWN`; empty: none.
        output: the plain output to switch; empty: none.
        active: the level that the output gets.
        scenario: the scenario for the testbench of a simulated tool; empty: none.
        part: the part that is to be gripped; empty: the default one.
    """

    command: Command | None = None
    wait_s: float = 0.0
    background: bool = False
    resume: bool = False
    stop: bool = False
    reset: bool = False
    reload: bool = False
    arm: bool = False
    show: str = ""
    output: str = ""
    active: bool = False
    scenario: str = ""
    part: str = ""


def read_script(text: str) -> tuple[ScriptCommand, ...]:
    """Parse text such as ``lock; grip &; wait 2; cancel; quit``; a line end separates commands as ``;`` does.

    Raises:
        UsageError: a step is not a command; the error names the step and suggests a similar word.
    """
    lines = (line.partition("#")[0] for line in text.splitlines())
    parts = (part.strip() for line in lines for part in line.split(";"))
    return tuple(read_command(part) for part in parts if part)


def read_command(text: str) -> ScriptCommand:
    """Parse one step of a script; raises UsageError."""
    words = text.lower().removesuffix("&").split()
    background = text.rstrip().endswith("&")
    verb, *rest = words or [""]
    if verb == WAIT:
        if background:
            raise UsageError(f"{text!r}: a wait cannot go on in the background.")
        return ScriptCommand(wait_s=_seconds(text, rest))
    if verb == SET:
        return _output(text, rest)
    if verb == SCENARIO:
        return _scenario(text)
    if verb not in WORDS:
        close = get_close_matches(verb, WORDS, n=1)
        plain = ", ".join(WORDS[: WORDS.index(SET)])
        known = f"There are: {plain}, set <output> on|off, wait <seconds>, scenario <text>."
        todo = f"Did you mean {close[0]!r}?" if close else known
        raise UsageError(f"{verb or text!r} is not a command.", todo=todo)
    if verb == "grip" and len(rest) == 1 and rest[0].isidentifier():
        return ScriptCommand(Command.GRIP, background=background, part=rest[0])
    if rest:
        between = (
            "Separate commands by ';', also behind an '&'." if "&" in text else "Separate commands by ';'."
        )
        raise UsageError(f"{text!r}: nothing may follow {verb!r}.", todo=between)
    if verb == RESUME:
        return ScriptCommand(resume=True)
    if verb == ARM:
        return ScriptCommand(arm=True)
    if verb == STOP:
        return ScriptCommand(stop=True)
    if verb == RESET:
        return ScriptCommand(reset=True)
    if verb == RELOAD:
        return ScriptCommand(reload=True)
    if verb in SHOWN:
        return ScriptCommand(show=verb)
    return ScriptCommand(VERBS[verb], background=background)


def _output(text: str, rest: list[str]) -> ScriptCommand:
    if len(rest) != 2 or rest[1] not in LEVELS:
        raise UsageError(f"{text!r}: expected is 'set <output> on' or 'set <output> off'.")
    return ScriptCommand(output=rest[0], active=LEVELS[rest[1]])


def _scenario(text: str) -> ScriptCommand:
    scenario = text.strip()[len(SCENARIO) :].strip()
    if not scenario:
        raise UsageError(
            f"{text!r}: expected is 'scenario <text>', for example 'scenario nominal'.",
            todo="`eehal testbench --list` lists them.",
        )
    return ScriptCommand(scenario=scenario)


def _seconds(text: str, rest: list[str]) -> float:
    try:
        seconds = float(rest[0]) if len(rest) == 1 else math.nan
    except ValueError:
        seconds = math.nan
    if not 0 <= seconds <= LONGEST_WAIT_S:
        raise UsageError(f"{text!r}: expected is 'wait <seconds>', for example 'wait 2.5'.")
    return seconds
