"""The interfaces of line back-ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Protocol, runtime_checkable

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.vocabulary import hint


class LineBackend(Protocol):
    """All output lines of an end-effector, claimed by one process. Not thread-safe."""

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Claim all the lines at once, and adopt their state.

        An output keeps its level. An input becomes an inactive output: a pull-up is not a command.

        Returns:
            The levels after adoption, without lines of unknown level.

        Raises:
            LineNotFoundError: a name is missing or ambiguous.
            LineBusyError: another process has a line; the message names it.
            WireError: the chip cannot be used.
        """
        ...

    def levels(self) -> dict[str, bool]:
        """Return the levels of the claimed lines, read back. They prove that the lines are written, not that an
        actuator moved.

        Lines of unknown level are left out.
        """
        ...

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of the claimed lines at once."""
        ...

    def close(self) -> None:
        """Release the lines; where the hardware allows it, they keep their levels."""
        ...


@runtime_checkable
class LineHandover(Protocol):
    """A `LineBackend` whose claim consists of descriptors that a service manager can store."""

    def descriptors(self) -> Mapping[str, int]:
        """Return the descriptors of the present claim, by names without a colon; this back-end keeps them open too."""
        ...

    def restore(self, descriptors: Mapping[str, int]) -> None:
        """Use the stored descriptors of a predecessor; call this before `request`. A descriptor that fits no line is
        closed.
        """
        ...


@runtime_checkable
class RemoteLines(Protocol):
    """A `LineBackend` whose writes pass through a device: they may be late or lost."""

    def unsure(self) -> frozenset[str]:
        """Return the lines of unknown state: a write is in progress, or the device reports another level."""
        ...

    def owed(self) -> frozenset[str]:
        """Return the lines whose deactivation was commanded, and which their device has not acknowledged."""
        ...

    def activating(self) -> frozenset[str]:
        """Return the lines whose activation has been in progress for longer than one write takes."""
        ...

    def withdraw(self, lines: Iterable[str], why: str) -> None:
        """Cancel activations of these lines that are not done yet; ``why``: a clause."""
        ...

    def prepare(
        self, lines: Iterable[str], values: Mapping[str, tuple[int, ...]], given: Mapping[str, int]
    ) -> None:
        """Mark the next deactivation of these lines as a Drop: their devices may be acknowledged and
        activated first.

        Args:
            lines: the lines.
            values: the registers with which their next activation grips, by line.
            given: when the next command was given first, by line, µs, where an earlier arbiter has given it.
        """
        ...

    def acknowledge(self) -> None:
        """Clear faults of the devices at a reset, where that cannot move a held part."""
        ...

    def troubles(self) -> Mapping[str, str]:
        """Return the present troubles, a clause by line; of a line that was never set: that it cannot be read."""
        ...

    def filenos(self) -> Sequence[int]:
        """Return descriptors of the claimed lines; one becomes readable when `unsure` or `troubles` change, until
        `heard`.
        """
        ...

    def heard(self) -> None:
        """Clear the notification; the caller reads `unsure` and `troubles` next."""
        ...


def line_not_found(
    missing: Sequence[str], found: Sequence[str] = (), *, looked_at: Sequence[str]
) -> LineNotFoundError:
    """Return an error that names all missing lines, similar names, and the places that were searched."""
    texts = [f"{name}{hint(name, found)}" for name in missing]
    return LineNotFoundError(
        f"there is no line {', '.join(texts)}.",
        where=", ".join(looked_at),
        todo="gpioinfo lists the lines of the GPIO chips.",
    )


@contextmanager
def wire_errors(what: str, where: object, todo: str) -> Iterator[None]:
    """Raise an OSError of the block as a WireError; ``what``: the failed action, to which the reason is added."""
    try:
        yield
    except WireError:
        raise
    except OSError as error:
        raise WireError(f"{what}: {error.strerror}.", where=str(where), todo=todo) from error
