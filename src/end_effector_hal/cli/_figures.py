"""Figures are drawn by the workshop, which a robot does not need: found by an entry point, or asked for in words."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from end_effector_hal.errors import UsageError

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
    """What draws; raises UsageError when it is not installed."""
    for point in entry_points(group=GROUP):
        if find_spec("matplotlib") is not None:
            return cast(Figures, point.load())
    raise UsageError(
        "Figures need matplotlib, which is not installed.",
        todo="Install it: pip install 'end-effector-hal[lab]'.",
    )


def save_all(figure: object, folder: Path, name: str) -> list[Path]:
    """Write a figure in each format."""
    return [figures().save(figure, folder / f"{name}.{suffix}") for suffix in FORMATS]


def draw_timeline(log: StatesLog, info: RunInfo, folder: Path) -> list[Path]:
    """Draw the run of a model: ``timeline.png`` and ``timeline.svg``."""
    return save_all(figures().timeline(log, None, info), folder, "timeline")
