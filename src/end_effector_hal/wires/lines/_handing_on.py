"""What a back-end can give its successor, so that lines are claimed without a gap while their owner is replaced."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable


@runtime_checkable
class LineHandover(Protocol):
    """A `LineBackend` whose claim lies in descriptors that a service manager can keep."""

    def keepsakes(self) -> Mapping[str, int]:
        """Descriptors of what is claimed now, by names without a colon; they stay this back-end's own."""
        ...

    def inherit(self, keepsakes: Mapping[str, int]) -> None:
        """Before `request`: take what a predecessor gave; what fits no line is closed, with its claim."""
        ...
