"""From a file to a description."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.errors import DescriptionError

from ._examine import examine
from ._model import Description


def load(path: str | Path) -> Description:
    """Read a description.

    Raises:
        DescriptionError: the file cannot be read, or is not a valid description. ``faults`` has every fault,
            in the order of the file: ``file:line:column: what (offending text), expected …; hint [code]``.
    """
    examination = examine(path)
    if examination.description is None:
        raise DescriptionError(examination.diagnostics)
    return examination.description
