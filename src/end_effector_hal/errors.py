"""The errors of the product: each reports what happened, where, and the remedy.

Every class has a stable code and an exit code.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from timed_automata.errors import Diagnostic, ModelError, RangeError, ReportedError, StoppedError, UsageError

__all__ = [
    "ArbiterError",
    "DescriptionError",
    "Diagnostic",
    "LineBusyError",
    "LineNotFoundError",
    "LineRefusedError",
    "LinkBusyError",
    "LinkError",
    "MissingExtraError",
    "ModelError",
    "NotReadyError",
    "RangeError",
    "ReportedError",
    "RosError",
    "StoppedError",
    "UsageError",
    "WireError",
    "WorkersError",
    "os_errors",
]


class DescriptionError(ReportedError, ValueError):
    """A description is not valid; ``faults`` holds every fault found, as one printable line per fault."""

    code = "EE-200"
    exit_code = 2

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self._diagnostics = tuple(diagnostics)
        self.faults = [str(each) for each in diagnostics]
        super().__init__("\n".join(self.faults))

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Every fault, in the order of the file."""
        return self._diagnostics


class MissingExtraError(UsageError):
    """A command or a codec needs a package of an extra that is not installed; the error has the command."""

    code = "EE-101"


class WireError(ReportedError, OSError):
    """A line or a link cannot be used."""

    code = "EE-400"
    exit_code = 3


class LineNotFoundError(WireError):
    """A line name is missing on this machine, or exists on more than one chip."""

    code = "EE-401"


class LineBusyError(WireError):
    """Another process holds the lines."""

    code = "EE-402"


class LineRefusedError(WireError):
    """The line arbiter refused a write because of an interlock."""

    code = "EE-403"


class LinkError(WireError):
    """A sensor link cannot be opened, or was lost."""

    code = "EE-410"


class LinkBusyError(LinkError):
    """Another process reads the sensor link."""

    code = "EE-411"


class ArbiterError(WireError):
    """The line arbiter cannot be reached, or does not answer."""

    code = "EE-420"


class NotReadyError(WireError, TimeoutError):
    """A tool did not become ready in time; the error names what is missing."""

    code = "EE-430"


class RosError(ReportedError, OSError):
    """ROS is not installed, or its master cannot be reached."""

    code = "EE-500"
    exit_code = 3


class WorkersError(ReportedError, OSError):
    """The processes or machines that share a computation cannot be reached, are not compatible, or died."""

    code = "EE-610"
    exit_code = 3


@contextmanager
def os_errors(what: str, where: Path | str, *, todo: str = "") -> Iterator[None]:
    """Raise an OSError of the block as a UsageError.

    Its text has the failed action (``what``), the system's reason, and the place.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(f"{what}: {error.strerror}.", where=str(where), todo=todo) from None
