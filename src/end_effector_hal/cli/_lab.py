"""Figures, drawn by the development tools; an error names the extra that is missing."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from end_effector_hal._extras import lab, missing_extra
from end_effector_hal.errors import MissingExtraError

if TYPE_CHECKING:
    from end_effector_hal.recording import RunInfo, StatesLog


FORMATS = ("png", "svg")


def figures() -> Any:
    """Return `end_effector_lab.figures`; raises MissingExtraError if a package that it needs is not installed."""
    try:
        import_module("matplotlib")  # the module that draws imports it later
    except ModuleNotFoundError as error:
        raise missing_extra("Figures need", error) or error from None
    return lab("figures")


def is_figure(output: Path) -> bool:
    """Return whether ``-o`` names a figure (``FILE.png`` or ``FILE.svg``) and not a folder."""
    return output.suffix.lstrip(".").lower() in FORMATS and not output.is_dir()


def draw_run(log: StatesLog, info: RunInfo, file: Path) -> Path:
    """Write the timeline of a run into one file; raises MissingExtraError, UsageError."""
    drawn: Path = figures().save(figures().timeline(log, None, info), file)
    return drawn


def save_all(figure: object, folder: Path, name: str) -> list[Path]:
    """Write a figure in every format and return the files."""
    return [figures().save(figure, folder / f"{name}.{suffix}") for suffix in FORMATS]


class Drawing:
    """Draws runs of a model. If the extra for figures is not installed, nothing is drawn, and ``note`` gives the
    reason.
    """

    def __init__(self) -> None:
        self.note = ""

    def __call__(self, log: StatesLog, info: RunInfo, folder: Path) -> list[Path]:
        """Write ``timeline.png`` and ``timeline.svg``; if figures cannot be drawn, set the note and return no files."""
        try:
            return save_all(figures().timeline(log, None, info), folder, "timeline")
        except MissingExtraError as error:
            self.note = f"There is no figure. {error}"
            return []
