"""The errors of the product: what happened, where, and what to do; each with a stable code and an exit code."""

from __future__ import annotations


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


class UsageError(EndEffectorError, ValueError):
    """A command was given something that it cannot use."""

    code = "EE-100"
    exit_code = 2


class DescriptionError(EndEffectorError, ValueError):
    """A description is not valid; ``faults`` holds every fault found, each a line ready to print."""

    code = "EE-200"
    exit_code = 2

    def __init__(self, faults: list[str]) -> None:
        self.faults = faults
        super().__init__("\n".join(faults))


class ModelError(EndEffectorError, ValueError):
    """The UPPAAL file is not valid, or uses something outside of the supported subset."""

    code = "EE-300"
    exit_code = 2


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


class RosError(EndEffectorError, OSError):
    """ROS is not installed, or its master cannot be reached."""

    code = "EE-500"
    exit_code = 3


class BoardError(EndEffectorError, OSError):
    """The emulated board cannot be built, or did not do its job."""

    code = "EE-600"
    exit_code = 3
