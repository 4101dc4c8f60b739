"""Figures and ``--sweep``: functions of the development tools, found by an entry point; an error names the extra."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from end_effector_hal._extras import command_for, lab_installed, lab_needed, missing_extra
from end_effector_hal.errors import MissingExtraError, UsageError
from end_effector_hal.plugins import Plugins, a_function

if TYPE_CHECKING:
    from end_effector_hal.recording import RunInfo, StatesLog
    from timed_automata import Template


NAME = "lab"
FORMATS = ("png", "svg")
_NAMED = ("timeline", "draw_template", "save")


class Figures(Protocol):
    """The functions of the module that the entry point names."""

    def timeline(self, log: StatesLog, pressures: None, info: RunInfo) -> object:
        """Draw the states of a run as lanes."""
        ...

    def draw_template(self, template: Template, constants: Mapping[str, object]) -> object:
        """Draw a template as UPPAAL shows it."""
        ...

    def save(self, figure: object, path: Path) -> Path:
        """Write a figure in the format that the suffix of the path names."""
        ...


def _drawing_module(module: Any) -> Figures:
    if not all(callable(getattr(module, name, None)) for name in _NAMED):
        raise UsageError(f"it lacks one of {', '.join(_NAMED)}.")
    return cast(Figures, module)


_FIGURES: Plugins[Figures] = Plugins(
    "end_effector_hal.figures", "drawing module", {}, _drawing_module, make=False
)


def figures() -> Figures:
    """Return the module that draws figures.

    Raises:
        MissingExtraError: the module, or a package that it needs, is not installed.
        UsageError: the module cannot be loaded.
    """
    if NAME not in _FIGURES.names:
        raise MissingExtraError(
            "The package that draws figures is not installed.", todo=f"Install it: {command_for('lab')}."
        )
    try:
        import_module("matplotlib")  # the module that draws imports it later
    except ModuleNotFoundError as error:
        raise missing_extra("Figures need", error) or error from None
    return _FIGURES.get(NAME)


def is_figure(output: Path) -> bool:
    """Return whether ``-o`` names a figure (``FILE.png`` or ``FILE.svg``) and not a folder."""
    return output.suffix.lstrip(".").lower() in FORMATS and not output.is_dir()


def draw_run(log: StatesLog, info: RunInfo, file: Path) -> Path:
    """Write the timeline of a run into one file; raises MissingExtraError, UsageError."""
    return figures().save(figures().timeline(log, None, info), file)


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


_SWEEPS = Plugins("end_effector_hal.sweep", "sweep", {}, a_function, make=False)


def sweep() -> Callable[..., int]:
    """Return the function that proves a grid of values, prints the results, and returns the exit code.

    Raises:
        MissingExtraError: the function is not installed.
        UsageError: the function cannot be loaded.
    """
    if not lab_installed():
        raise lab_needed("--sweep")
    return _SWEEPS.get(NAME)
