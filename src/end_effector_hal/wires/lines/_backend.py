"""What a line back-end must do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol


class LineBackend(Protocol):
    """All output lines of an end-effector, claimed by one owner. Not thread-safe."""

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Claim the lines, all at once, and adopt them.

        An output keeps its level, an input becomes an inactive output: a pull-up is not a command.

        Returns:
            The levels after adoption.

        Raises:
            LineNotFoundError: a name is missing or ambiguous.
            LineBusyError: somebody else has a line; says who.
            WireError: the chip cannot be used.
        """
        ...

    def levels(self) -> dict[str, bool]:
        """The levels of the claimed lines, read back; they prove the claim, not the actuator."""
        ...

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of the claimed lines, at once."""
        ...

    def close(self) -> None:
        """Give the claim back; the levels stay where the hardware keeps them."""
        ...
