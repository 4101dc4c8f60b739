"""The errors of the product: what happened, where, and what to do; each with a stable code and an exit code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Told:
    """One fault, as every command tells it; ``line`` and ``column`` are 0 where there are none."""

    code: str
    file: str
    line: int
    column: int
    message: str

    @classmethod
    def at(cls, code: str, where: str, message: str) -> Told:
        """A fault at ``file:line:column``, or at whatever else ``where`` names."""
        file, *numbers = where.rsplit(":", 2)
        if len(numbers) == 2 and all(each.isdigit() for each in numbers):
            return cls(code, file, int(numbers[0]), int(numbers[1]), message)
        return cls(code, where, 0, 0, message)

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        return f"{place}: {self.message} [{self.code}]" if place else f"{self.message} [{self.code}]"

    def as_json(self) -> dict[str, object]:
        """For ``--json``."""
        return asdict(self)


class EndEffectorError(Exception):
    """Anything the product refuses or fails at.

    Args:
        what: one sentence that says what happened.
        where: ``file:line:column``, a line name, a port, …
        todo: what the reader can do about it.
    """

    code = "EE-000"
    exit_code = 1

    def __init__(self, what: str, *, where: str = "", todo: str = "") -> None:
        self.what, self.where, self.todo = what, where, todo
        super().__init__(what)

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        advice = f" {self.todo}" if self.todo else ""
        return f"{place}{self.what}{advice}"

    @property
    def told(self) -> tuple[Told, ...]:
        """What it says, fault by fault."""
        return (Told.at(self.code, self.where, f"{self.what} {self.todo}".strip()),)


class UsageError(EndEffectorError, ValueError):
    """A command was given something that it cannot use."""

    code = "EE-100"
    exit_code = 2


class DescriptionError(EndEffectorError, ValueError):
    """A description is not valid; ``faults`` holds every fault found, each a line ready to print."""

    code = "EE-200"
    exit_code = 2

    def __init__(self, told: Sequence[Told]) -> None:
        self._told = tuple(told)
        self.faults = [str(each) for each in told]
        super().__init__("\n".join(self.faults))

    @property
    def told(self) -> tuple[Told, ...]:
        """Every fault, in the order of the file."""
        return self._told


class ModelError(EndEffectorError, ValueError):
    """The UPPAAL file is not valid, or uses something outside of the supported subset."""

    code = "EE-300"
    exit_code = 2


class RangeError(ModelError):
    """An assignment, an index or a division left its range while the network ran: the model is wrong."""

    code = "EE-301"


class WireError(EndEffectorError, OSError):
    """A line or a link cannot be used."""

    code = "EE-400"
    exit_code = 3


class LineNotFoundError(WireError):
    """A line name is missing on this machine, or stands on more than one chip."""

    code = "EE-401"


class LineBusyError(WireError):
    """Somebody else holds the lines."""

    code = "EE-402"


class LineRefusedError(WireError):
    """The line owner refused a write because of an interlock."""

    code = "EE-403"


class LinkError(WireError):
    """A sensor link cannot be opened or has gone."""

    code = "EE-410"


class LinkBusyError(LinkError):
    """Somebody else reads the sensor link."""

    code = "EE-411"


class OwnerError(WireError):
    """The line owner cannot be reached, or does not answer."""

    code = "EE-420"


class NotReadyError(WireError, TimeoutError):
    """A tool did not become ready in time; says what is missing."""

    code = "EE-430"


class RosError(EndEffectorError, OSError):
    """ROS is not installed, or its master cannot be reached."""

    code = "EE-500"
    exit_code = 3


class BoardError(EndEffectorError, OSError):
    """The emulated board cannot be built, or did not do its job."""

    code = "EE-600"
    exit_code = 3
