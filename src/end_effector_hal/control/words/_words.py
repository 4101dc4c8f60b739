"""The words for the values of the automata's variables: of Table II, of the evidence, of each kind's states."""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import IntEnum

from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import Cause, ChangerFault, ChangerState, Command, EndEffectorState, Evidence

_WORDS: dict[str, Callable[[int], IntEnum]] = {
    "ee": EndEffectorState,
    "command": Command,
    "changer_command": Command,
    "cause": Cause,
    "changer": ChangerState,
    "changer_fault": ChangerFault,
    "evidence": Evidence,
}
_INDEXED = re.compile(r"(\w+)\[(\d+)\]")


def word_of(description: Description, variable: str, value: int) -> str | None:
    """The word for a value of a variable such as ``ee`` or ``actuator[1]``; None: it is a number."""
    found = _INDEXED.fullmatch(variable)
    name, index = (found[1], int(found[2])) if found else (variable, -1)
    try:
        if name == "actuator":
            return kind_of(description.ordered[index][1]).states(value).label
        return _WORDS[name](value).name
    except (KeyError, ValueError, IndexError):
        return None
