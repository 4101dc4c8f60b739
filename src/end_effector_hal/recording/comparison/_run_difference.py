"""A difference between two recordings."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class RunDifference:
    """A difference, with its line of the figure and its time.

    Args:
        line: ``end_effector``, ``command``, an actuator, ``tool_changer``, ``alarms``, or the channel of a pressure.
        text: the difference in words.
        first_s, second_s: time, seconds since the start of each recording; None: absent from that recording.
    """

    line: str
    text: str
    first_s: float | None
    second_s: float | None

    def as_json(self) -> dict[str, Any]:
        """Return the fields as JSON."""
        return asdict(self)


def count_differences(number: int) -> str:
    """Return the number in words: ``no difference``, ``1 difference``, ``2 differences``."""
    return f"{number or 'no'} difference{'s' * (number > 1)}"
