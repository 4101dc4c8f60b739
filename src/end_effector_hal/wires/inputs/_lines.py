"""What reads the digital inputs of a board must do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from end_effector_hal.description import Description, DigitalInput
from end_effector_hal.wires.lines import Pull


class LineEdge(NamedTuple):
    """An input line changed its level.

    Attributes:
        at: µs on the monotonic clock, by the one who saw it first: the kernel.
        line: its name.
        high: the level of the pin from then on.
    """

    at: int
    line: str
    high: bool


class Edges(NamedTuple):
    """What has come since the last look; ``lost``: there were more, and nobody knows which."""

    edges: Sequence[LineEdge] = ()
    lost: bool = False


class InputLines(Protocol):
    """Digital inputs, claimed by one reader. Not thread-safe."""

    def request(self, inputs: Mapping[str, DigitalInput]) -> None:
        """Claim the lines, all at once, with their bias and debounce.

        Raises:
            LineNotFoundError: a name is missing or ambiguous.
            LineBusyError: somebody else has a line; says who.
            WireError: the chip cannot be used.
        """
        ...

    def fds(self) -> Sequence[int]:
        """Descriptors of which one is readable when there is an edge."""
        ...

    def due(self) -> int | None:
        """µs when an edge comes without a descriptor saying so; None: at no time."""
        ...

    def edges(self) -> Edges:
        """The edges that have come, in their order; does not wait. Raises WireError: the chip has gone."""
        ...

    def levels(self) -> dict[str, bool]:
        """Which lines are high now. Raises WireError: the chip has gone."""
        ...

    def close(self) -> None:
        """Give the lines back; nothing happens the second time."""
        ...


def pulls_of(inputs: Mapping[str, DigitalInput]) -> dict[str, Pull]:
    """How a virtual chip must hold the lines while nobody drives them: as their bias says, else down."""
    return {line: "up" if each.bias == "pull_up" else "down" for line, each in inputs.items()}


def input_lines(description: Description) -> dict[str, DigitalInput]:
    """The digital inputs of a tool by the name of their line."""
    return {each.digital.line: each.digital for each in description.channels.values() if each.digital}
