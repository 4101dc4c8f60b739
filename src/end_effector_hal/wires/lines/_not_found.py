"""The error for a line name that is not there."""

from __future__ import annotations

from collections.abc import Sequence

from end_effector_hal.errors import LineNotFoundError
from end_effector_hal.vocabulary import hint


def line_not_found(
    missing: Sequence[str], found: Sequence[str], looked_at: Sequence[str]
) -> LineNotFoundError:
    """Names every missing line at once, what it may have meant, and where was looked."""
    texts = [f"{name}{hint(name, found)}" for name in missing]
    return LineNotFoundError(
        f"there is no line {', '.join(texts)}.",
        where=", ".join(looked_at),
        todo="gpioinfo lists the lines of the GPIO chips.",
    )
