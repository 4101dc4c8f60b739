"""The figures, with matplotlib imported only when one is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import AlarmRow, Moment, PressuresLog, RunInfo, StatesLog

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def timeline(
    log: StatesLog,
    pressures: PressuresLog | None = None,
    info: RunInfo | None = None,
    alarms: Sequence[AlarmRow] = (),
    moments: Sequence[Moment] = (),
) -> Figure:
    """States as lanes with their names inside, events on top, pressures with their accepted range below.

    ``moments``: to be marked besides those of the story.

    Raises UsageError for a recording without a row.
    """
    _need_rows(log)
    from end_effector_lab.figures._timeline import draw

    return draw(log, pressures, info or RunInfo(), alarms, moments)


def paper(log: StatesLog, info: RunInfo | None = None) -> Figure:
    """Offset step curves with the state names at the transitions, as in Figs. 7 to 9 of the paper.

    Raises UsageError for a recording without a row.
    """
    _need_rows(log)
    from end_effector_lab.figures._paper import draw

    return draw(log, info or RunInfo())


def save(figure: Figure, path: str | Path) -> Path:
    """Save as PNG or SVG, by the suffix; the same figure gives the same bytes. Raises UsageError."""
    from end_effector_lab.figures._save import write

    return write(figure, Path(path))


def _need_rows(log: StatesLog) -> None:
    if not log.rows:
        raise UsageError("This recording holds no row, so there is nothing to draw.", where=log.source)
