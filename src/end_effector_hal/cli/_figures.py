"""Figures are drawn by the development tools, found by an entry point, or asked for in words."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from end_effector_hal._extras import command_for, missing_extra
from end_effector_hal.errors import MissingExtraError, UsageError
from end_effector_hal.plugins import Plugins

if TYPE_CHECKING:
    from end_effector_hal.recording import RunInfo, StatesLog
    from timed_automata import Template

GROUP = "end_effector_hal.figures"
NAME = "lab"
FORMATS = ("png", "svg")
_NAMED = ("timeline", "draw_template", "save")


class Figures(Protocol):
    """What the entry point names."""

    def timeline(self, log: StatesLog, pressures: None, info: RunInfo) -> object:
        """The states of a run as lanes."""
        ...

    def draw_template(self, template: Template, constants: Mapping[str, object]) -> object:
        """A template as UPPAAL shows it."""
        ...

    def save(self, figure: object, path: Path) -> Path:
        """Write a figure in the format of the suffix."""
        ...


def _checked(module: Any) -> Figures:
    if not all(callable(getattr(module, name, None)) for name in _NAMED):
        raise UsageError(f"it lacks one of {', '.join(_NAMED)}.")
    return cast(Figures, module)


_FIGURES: Plugins[Figures] = Plugins(GROUP, "drawing module", {}, _checked, make=False)


def figures() -> Figures:
    """The module that draws.

    Raises:
        MissingExtraError: it, or what it needs, is not installed.
        UsageError: it cannot be loaded.
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
    """Whether ``-o`` names a figure, ``FILE.png`` or ``FILE.svg``, and no folder."""
    return output.suffix.lstrip(".").lower() in FORMATS and not output.is_dir()


def draw_run(log: StatesLog, info: RunInfo, file: Path) -> Path:
    """Write the timeline of a run into one file; raises MissingExtraError, UsageError."""
    return figures().save(figures().timeline(log, None, info), file)


def save_all(figure: object, folder: Path, name: str) -> list[Path]:
    """Write a figure in each format."""
    return [figures().save(figure, folder / f"{name}.{suffix}") for suffix in FORMATS]


class Drawing:
    """Draws runs of a model; ``note`` says why there is no figure, where the extra for figures is not installed."""

    def __init__(self) -> None:
        self.note = ""

    def __call__(self, log: StatesLog, info: RunInfo, folder: Path) -> list[Path]:
        """``timeline.png`` and ``timeline.svg``; nothing, and the note, where nothing can be drawn."""
        try:
            return save_all(figures().timeline(log, None, info), folder, "timeline")
        except MissingExtraError as error:
            self.note = f"There is no figure. {error}"
            return []
