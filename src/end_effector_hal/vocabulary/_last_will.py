"""The limits of a tool, and the last will of a client: what the line arbiter does when the client dies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from end_effector_hal.errors import UsageError

MOST_ACTUATORS = 64
"""Largest number of actuators of a tool; also the limit for plain outputs."""
MOST_LINES = 2 * MOST_ACTUATORS
"""Largest number of lines that one program writes in one message: each actuator, and its blow-off."""
MOST_CHANNELS = 4 * MOST_ACTUATORS + 6
"""Largest number of channels of a tool.

Each actuator has three switches and an alarm; the tool changer has four bits; then supply and e-stop.
"""
MOST_PREDICATES = 2 * MOST_CHANNELS + 4
"""Largest number of predicates in a message: two per channel with alarms, four of changer and e-stop."""
LONGEST_MESSAGE = 1 << 18
"""Longest message, bytes.

It is enough for a ``set`` of MOST_LINES names of 64 characters with its last will, all escaped.
"""


LONGEST_US = 600_000_000
LEASE_US = 1_000_000
"""Time after which a client that has not renewed its lease is declared dead, µs."""
SETTLE_US = 50_000
"""Shortest time between two changes of a line, µs (IL-10)."""


class LastWillStep(NamedTuple):
    """One deactivation of a last will.

    Attributes:
        line: name of the line.
        level: False; a last will activates nothing (IL-11).
        after_us: time after the death, not after the previous step, µs; the steps are sorted by it.
    """

    line: str
    level: bool = False
    after_us: int = 0

    def as_json(self) -> dict[str, object]:
        """Return the step as it is written in a message."""
        return {"line": self.line, "level": self.level, "after_us": self.after_us}


class WrittenPart(NamedTuple):
    """What a write says of the part that is gripped.

    Attributes:
        name: its name; empty: it has none.
        values: registers that make an output grip this part, by line, where they depend on the part.
    """

    name: str = ""
    values: Mapping[str, tuple[int, ...]] = {}


NO_PART = WrittenPart()
LastWill = tuple[LastWillStep, ...]
"""Steps in order; empty: hold, every line stays as it is."""


def read_last_will(steps: object) -> LastWill:
    """Return a last will from a message, or from any other list of steps.

    Raises:
        UsageError: it is not valid; the error names the step and the reason.
    """
    if not isinstance(steps, list | tuple):
        if not isinstance(steps, Iterable) or isinstance(steps, str | Mapping):
            raise UsageError("a last will must be a list of steps.")
        steps = list(steps)
    will, before_us = list[LastWillStep](), 0
    for i, given in enumerate(steps):
        try:
            if type(given) is LastWillStep:
                step = given
            else:
                step = LastWillStep(*given) if isinstance(given, list | tuple) else LastWillStep(**given)
        except TypeError:
            raise UsageError(f"step {i} of the last will is not {{line, level, after_us}}.") from None
        line, level, after_us = step
        if not isinstance(line, str):
            raise UsageError(f"step {i} of the last will names no line.")
        if level is not False:
            raise UsageError(
                f"IL-11: step {i} of the last will would activate {line}; a last will only deactivates."
            )
        if type(after_us) is not int or not 0 <= after_us <= LONGEST_US:
            raise UsageError(
                f"step {i} of the last will: after_us must be an integer from 0 to {LONGEST_US}."
            )
        if after_us < before_us:
            raise UsageError("the steps of a last will must be in the order of their after_us.")
        before_us = after_us
        will.append(step)
    if len(will) > MOST_LINES:
        raise UsageError(f"a last will has at most {MOST_LINES} steps, this one has {len(will)}.")
    return tuple(will)
