"""What a line back-end must do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol, runtime_checkable

from end_effector_hal.errors import LineNotFoundError
from end_effector_hal.vocabulary import hint


class LineBackend(Protocol):
    """All output lines of an end-effector, claimed by one owner. Not thread-safe."""

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Claim the lines, all at once, and adopt them.

        An output keeps its level, an input becomes an inactive output: a pull-up is not a command.

        Returns:
            The levels after adoption; a line of which nobody knows how it stands is left out.

        Raises:
            LineNotFoundError: a name is missing or ambiguous.
            LineBusyError: somebody else has a line; says who.
            WireError: the chip cannot be used.
        """
        ...

    def levels(self) -> dict[str, bool]:
        """The levels of the claimed lines, read back; they prove the claim, not the actuator.

        A line of which nobody knows how it stands is left out.
        """
        ...

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of the claimed lines, at once."""
        ...

    def close(self) -> None:
        """Give the claim back; the levels stay where the hardware keeps them."""
        ...


@runtime_checkable
class LineHandover(Protocol):
    """A `LineBackend` whose claim lies in descriptors that a service manager can store."""

    def descriptors(self) -> Mapping[str, int]:
        """Descriptors of what is claimed now, by names without a colon; this back-end keeps them, too."""
        ...

    def restore(self, descriptors: Mapping[str, int]) -> None:
        """Use the stored descriptors of a predecessor; call it before `request`. One that fits no line is closed."""
        ...


@runtime_checkable
class RemoteLines(Protocol):
    """A `LineBackend` that does not write by itself: what it sends may be late, or lost on its way."""

    def unsure(self) -> frozenset[str]:
        """Lines of which nobody knows how they stand: a write is under way, or the device says otherwise."""
        ...

    def activating(self) -> frozenset[str]:
        """Lines whose activation has been under way for longer than one write takes."""
        ...

    def withdraw(self, lines: Iterable[str], why: str) -> None:
        """Activations of these that are not done yet are not done any more; ``why``: a clause."""
        ...

    def prepare(self, lines: Iterable[str]) -> None:
        """The next deactivation of these is a Drop: their devices may be acknowledged and activated before it."""
        ...

    def acknowledge(self) -> None:
        """Faults of the devices are cleared, where that moves nothing that may be held; somebody resets."""
        ...

    def troubles(self) -> Mapping[str, str]:
        """What is wrong with its lines now, a clause by line."""
        ...

    def filenos(self) -> Sequence[int]:
        """Of the claimed lines; one is readable when `unsure` or `troubles` have changed, until `heard`."""
        ...

    def heard(self) -> None:
        """Both are about to be asked."""
        ...


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
