"""Variants of the tool at hand: edits that its constants switch off are judged with other constants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from timed_automata import Network
from timed_automata.network import Given

Row = tuple[bool, ...] | tuple[int, ...]
Pattern = Mapping[str, bool | int | Row | tuple[Row, ...]]
_STEPS = 2
_TIMES: Pattern = {
    "ATTEMPTS": ((3, 2),),
    "T_CONFIRM": ((4000, 5000),),
    "T_RESET": (700, 1000),
    "T_GONE": (1500, 2000),
}
_FAR_MS = 1_000_000  # how long a command may take is asked of the tool at hand alone
_WIDE: Pattern = {"GRIP_BOUND": _FAR_MS, "RELEASE_BOUND": _FAR_MS, "CANCEL_BOUND": _FAR_MS}
_BLOWN_OFF: Pattern = {"BLOWS": True, "T_GAP": (150, 100), "IL_08_GAP": (50, 50), "UNTIL_GONE": (True, False)}
_ALONE: Pattern = {"N": 1, "CHANGER": False}

VARIANTS: Mapping[str, Pattern] = {
    "one step": {"N": 1},
    "one step, endings hold it": {
        **_ALONE,
        "CANCEL_KEEPS": (True,),
        "ABORT_KEEPS": (True,),
        "TIMEOUT_KEEPS": (True,),
        "DEATH_KEEPS": (True,),
    },
    "one step, a loss and the start release it": {
        **_ALONE,
        "LOSS_KEEPS": (False,),
        "START_KEEPS": (False,),
        "HELD_DEATH_KEEPS": (False,),
    },
    "one step, evidence of nothing, no tool changer": {**_ALONE, "SHOWS_EMPTY": True},
    "one step, blown off": {**_ALONE, **_BLOWN_OFF, "T_BLOW": (200,)},
    "a latching tool changer": {"N": 1, "LATCHING": True, "IL_02": False, "UNLOCK_KEEPS": True},
    "no sensors of the stand": {"N": 1, "STAND": False},
    "only the presence of the tool is shown": {"N": 1, "IL_05": False},
    "no sensor of the presence": {"N": 1, "PRESENCE": False},
    "one step, no IL-06": {"N": 1, "IL_06": False},
    "no tool changer, no IL-06 and IL-07": {
        "CHANGER": False,
        "SHOWS_EMPTY": True,
        "IL_06": False,
        "IL_07": False,
    },
    "an ending holds one of two": {
        "CANCEL_KEEPS": (True, False),
        "ABORT_KEEPS": (False, True),
        "TIMEOUT_KEEPS": (True, False),
        "DEATH_KEEPS": (False, True),
        "MIXED": True,
    },
    "endings hold both": {
        "CANCEL_KEEPS": (True, True),
        "ABORT_KEEPS": (True, True),
        "TIMEOUT_KEEPS": (True, True),
        "DEATH_KEEPS": (True, True),
    },
    "a loss and the start release both": {
        "LOSS_KEEPS": (False, False),
        "START_KEEPS": (False, False),
        "HELD_DEATH_KEEPS": (False, False),
    },
    "a loss and the start release one of two": {
        "LOSS_KEEPS": (False, True),
        "START_KEEPS": (True, False),
        "MIXED": True,
    },
    "one step, evidence of nothing": {"N": 1, "SHOWS_EMPTY": True},
    "evidence of nothing": {"SHOWS_EMPTY": True},
    "one is blown off, a cancel holds the other": {
        **_BLOWN_OFF,
        "T_BLOW": (200, 0),
        "CANCEL_KEEPS": (False, True),
        "MIXED": True,
    },
    "both are blown off": {**_BLOWN_OFF, "T_BLOW": (200, 150)},
    "no IL-01": {"N": 1, "IL_01": False},
    "two steps": {},
    "two parts": {
        "PARTS": 2,
        "USES": ((True, False), (True, True)),
        "ATTEMPTS": ((3, 2), (2, 3)),
        "T_CONFIRM": ((4000, 5000), (3000, 4500)),
    },
}
"""Constants by the variant's name, for a tool of two steps, or of one if that suffices; the quick ones first."""


def variants(network: Network, constants: Mapping[str, Given]) -> Iterator[tuple[str, dict[str, Given]]]:
    """Yield names and constants for the tool's first two steps, with other values that its automata have.

    Args:
        network: the automata with the constants of the tool.
        constants: these constants.
    """
    if "N" not in constants:
        return
    for words, changes in VARIANTS.items():
        if not changes.keys() <= network.constants.keys():
            continue
        steps = 1 if changes.get("N") == 1 else _STEPS
        order: Pattern = {"N": steps, "RELEASE_ORDER": tuple(reversed(range(steps)))}
        changed: dict[str, Given] = {**constants, **_WIDE, **_TIMES, **changes, **order}
        yield words, {name: _of(steps, value) for name, value in changed.items()}


def _of(steps: int, value: Given) -> Given:
    """Return a constant for a tool with this number of steps; of one for each part, each row of it."""
    if isinstance(value, Sequence) and value and isinstance(value[0], Sequence):
        return [_of(steps, row) for row in value]
    return (list(value) * steps)[:steps] if isinstance(value, Sequence) else value
