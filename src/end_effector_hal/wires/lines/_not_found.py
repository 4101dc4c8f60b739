"""The error for a line name that is not there."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches

from end_effector_hal.errors import LineNotFoundError


def line_not_found(
    missing: Sequence[str], found: Sequence[str], looked_at: Sequence[str]
) -> LineNotFoundError:
    """Names every missing line at once, what it may have meant, and where was looked."""
    texts = []
    for name in missing:
        close = get_close_matches(name, [other for other in found if other], n=1)
        texts.append(f"{name} (did you mean {close[0]}?)" if close else name)
    return LineNotFoundError(
        f"there is no line {', '.join(texts)}.",
        where=", ".join(looked_at),
        todo="gpioinfo lists the lines of the GPIO chips.",
    )
