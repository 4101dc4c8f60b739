"""The interface of a reader of a board's digital inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from end_effector_hal.description import Description, DigitalInput
from end_effector_hal.wires.lines import Pull


class LineEdge(NamedTuple):
    """A change of an input line's level.

    Attributes:
        at: µs on the monotonic clock, stamped where the edge was detected first (the kernel).
        line: name of the line.
        high: the level of the pin from then on.
    """

    at: int
    line: str
    high: bool


class Edges(NamedTuple):
    """The edges since the last call; ``lost``: some edges were lost, and it is unknown which."""

    edges: Sequence[LineEdge] = ()
    lost: bool = False


class InputLines(Protocol):
    """Digital inputs, claimed by one reader. Not thread-safe."""

    def request(self, inputs: Mapping[str, DigitalInput]) -> None:
        """Claim all the lines at once, with their bias and debounce.

        Raises:
            LineNotFoundError: a name is missing or ambiguous.
            LineBusyError: another process has a line; the message names it.
            WireError: the chip cannot be used.
        """
        ...

    def fds(self) -> Sequence[int]:
        """Return descriptors; one of them is readable when there is an edge."""
        ...

    def due(self) -> int | None:
        """Return the time of the next edge that no descriptor reports, µs; None: there is none."""
        ...

    def edges(self) -> Edges:
        """Return the new edges in order, without waiting. Raises WireError if the chip is lost."""
        ...

    def levels(self) -> dict[str, bool]:
        """Return whether each line is high now. Raises WireError if the chip is lost."""
        ...

    def close(self) -> None:
        """Release the lines; a second call has no effect."""
        ...


def pulls_of(inputs: Mapping[str, DigitalInput]) -> dict[str, Pull]:
    """Return the pulls of a virtual chip for lines that are not driven: from their bias, else down."""
    return {line: "up" if each.bias == "pull_up" else "down" for line, each in inputs.items()}


def input_lines(description: Description) -> dict[str, DigitalInput]:
    """Return the digital inputs of a tool by the name of their line."""
    return {each.digital.line: each.digital for each in description.channels.values() if each.digital}
