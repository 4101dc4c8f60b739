"""The words for the values of the automata's variables, and the reason why nothing is activated while the
e-stop cannot be read.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import IntEnum

from end_effector_hal.codecs import carrier_of, sources_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import ChannelReadings
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
    """Return the name of a value of a variable such as ``ee`` or ``actuator[1]``; None: it has no names."""
    found = _INDEXED.fullmatch(variable)
    name, index = (found[1], int(found[2])) if found else (variable, -1)
    try:
        if name == "actuator":
            return kind_of(description.ordered[index][1]).states(value).label
        return _WORDS[name](value).name
    except (KeyError, ValueError, IndexError):
        return None


def unread_e_stop(description: Description, readings: ChannelReadings, at: int) -> str:
    """Return a sentence if a fitted e-stop has no valid reading at ``at`` µs; else an empty text.

    The line arbiter then refuses every activation (IL-13), so that a grip would begin only to fail.
    """
    e_stop = description.e_stop
    if e_stop is None or e_stop.channel not in readings.carried:
        return ""
    if readings.get(e_stop.channel, at) is not None:
        return ""
    where = _source(description, e_stop.channel)
    return f"IL-13: the e-stop has no valid reading ({e_stop.channel}, {where}): nothing is activated until it has one."


def _source(description: Description, channel: str) -> str:
    declared = description.channels.get(channel)
    if declared is not None and declared.on_board:
        return "inputs of the board"
    sources = sources_of(carrier_of(description))
    return description.link_name(next(each.link for each in sources if channel in each.channels) or "")
