"""The figures, with matplotlib imported only when one is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import (
    AlarmRow,
    ChangerRow,
    Moment,
    PressuresLog,
    RunDifference,
    RunInfo,
    RunTables,
    StatesLog,
    SwitchesLog,
)
from end_effector_hal.verification.tune import Tuning
from end_effector_hal.verification.whatif import WhatIf
from timed_automata import Template

from ._heat_map_cell import HeatMapCell

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def timeline(
    log: StatesLog,
    pressures: PressuresLog | None = None,
    info: RunInfo | None = None,
    alarms: Sequence[AlarmRow] = (),
    moments: Sequence[Moment] = (),
    changer: Sequence[ChangerRow] = (),
    switches: SwitchesLog | None = None,
) -> Figure:
    """States as lanes with their names inside, events on top, switches and pressures with their thresholds below.

    ``moments``: to be marked besides those of the story; ``changer``: the lane of the tool changer; ``switches``: a
    lane for each that the run says what it proves.

    Raises UsageError for a recording without a row.
    """
    _need_rows(log)
    from ._timeline import draw

    return draw(log, pressures, info or RunInfo(), alarms, moments, changer, switches)


def paper(log: StatesLog, info: RunInfo | None = None) -> Figure:
    """Offset step curves with the state names at the transitions, as in Figs. 7 to 9 of the paper.

    Raises UsageError for a recording without a row.
    """
    _need_rows(log)
    from ._paper import draw

    return draw(log, info or RunInfo())


def overlay(
    first: RunTables, second: RunTables, differences: Sequence[RunDifference], names: tuple[str, str]
) -> Figure:
    """Two runs over each other, on the clock of the first one: each line twice, each pressure solid and dashed.

    ``differences``: are marked; ``names``: of both. Raises UsageError for a recording without a row.
    """
    _need_rows(first.log)
    _need_rows(second.log)
    from ._overlay import draw

    return draw(first, second, differences, names)


def what_if(told: WhatIf) -> Figure:
    """A recorded run and what another description would have made of it: lanes above each other, one axis of time.

    Raises UsageError where one of them holds no state.
    """
    from ._what_if import draw

    return draw(told)


def tuning(found: Tuning) -> Figure:
    """How many recorded grips would have gone otherwise, over the value of each number that changes anything.

    Raises UsageError where none does.
    """
    from ._tuning import draw

    return draw(found)


def draw_template(template: Template, constants: Mapping[str, object] | None = None) -> Figure:
    """A template where its file says: locations, edges through their nails, labels in UPPAAL's colours.

    Args:
        template: of a document.
        constants: by name; those that the template mentions are told under its name.

    Raises:
        UsageError: it would be too large to be drawn.
    """
    from .automata import draw

    return draw(template, constants or {})


def heat_map(
    title: str,
    x: tuple[str, Sequence[str]],
    y: tuple[str, Sequence[str]],
    cells: Mapping[tuple[str, str], HeatMapCell],
) -> Figure:
    """Cells as colours with their numbers; what does not hold has a frame and says what fails.

    Args:
        title: above it.
        x, y: the name of the axis and its values.
        cells: by the values of x and y.
    """
    from ._heat_map import draw

    return draw(title, x, y, cells)


def save(figure: Figure, path: str | Path) -> Path:
    """Save as PNG or SVG, by the suffix; the same figure gives the same bytes. Raises UsageError."""
    from ._save import write

    return write(figure, Path(path))


def _need_rows(log: StatesLog) -> None:
    if not log.rows:
        raise UsageError("This recording holds no row, so there is nothing to draw.", where=log.source)
