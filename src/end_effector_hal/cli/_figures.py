"""Figures are drawn by the workshop, which a robot does not need: found by an entry point, or asked for in words."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from end_effector_hal._extras import command_for, missing_extra
from end_effector_hal.errors import MissingExtraError

if TYPE_CHECKING:
    from end_effector_hal.recording import RunInfo, StatesLog
    from timed_automata import Template

GROUP = "end_effector_hal.figures"
FORMATS = ("png", "svg")


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


def figures() -> Figures:
    """The module that draws; raises MissingExtraError when it or what it needs is not installed."""
    for point in entry_points(group=GROUP):
        try:
            import_module("matplotlib")  # the module that draws imports it later
            return cast(Figures, point.load())
        except ModuleNotFoundError as error:
            raise missing_extra("Figures need", error) or error from None
    raise MissingExtraError(
        "Nothing that draws figures is installed.", todo=f"Install it: {command_for('lab')}."
    )


def save_all(figure: object, folder: Path, name: str) -> list[Path]:
    """Write a figure in each format."""
    return [figures().save(figure, folder / f"{name}.{suffix}") for suffix in FORMATS]


def draw_timeline(log: StatesLog, info: RunInfo, folder: Path) -> list[Path]:
    """Draw the run of a model: ``timeline.png`` and ``timeline.svg``."""
    return save_all(figures().timeline(log, None, info), folder, "timeline")
