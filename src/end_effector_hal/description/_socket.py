"""Where programs find the line arbiter of a tool."""

from __future__ import annotations

from pathlib import Path

from ._model import Description
from ._paths import run_directory


def socket_path(description: Description) -> Path:
    """The Unix socket of the line arbiter: the description's, or ``<name>.sock`` in the run directory.

    Raises:
        WireError: the run directory is not for this user alone.
    """
    if description.lines.socket:
        return Path(description.lines.socket)
    return run_directory() / f"{description.name}.sock"
