"""One thing in which two recordings differ."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class RunDifference:
    """What differs, on which line of the figure, and when.

    Args:
        line: ``end_effector``, ``command``, an actuator, ``tool_changer``, ``alarms``, or the channel of a pressure.
        text: what differs, in words.
        first_s, second_s: when, seconds since the start of each recording; None: it is not in that one.
    """

    line: str
    text: str
    first_s: float | None
    second_s: float | None

    def as_json(self) -> dict[str, Any]:
        """Its fields."""
        return asdict(self)


def count_differences(number: int) -> str:
    """How many there are, in words: ``no difference``, ``1 difference``, ``2 differences``."""
    return f"{number or 'no'} difference{'s' * (number > 1)}"
