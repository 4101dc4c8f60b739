"""Handover: a back-end gives its successor the descriptors of its lines, so that the claim has no gap."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable


@runtime_checkable
class LineHandover(Protocol):
    """A `LineBackend` whose claim lies in descriptors that a service manager can store."""

    def descriptors(self) -> Mapping[str, int]:
        """Descriptors of what is claimed now, by names without a colon; this back-end keeps them, too."""
        ...

    def restore(self, descriptors: Mapping[str, int]) -> None:
        """Use the stored descriptors of a predecessor; call it before `request`. One that fits no line is closed."""
        ...
