"""A grid of numbers, and which of its cells do not hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ._heat_map_cell import HeatMapCell
from ._style import INK, MUTED, NOTHING, WRONG, drawing

_WORD = 14
"""Letters that fit into a cell."""


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
    (along, columns), (up, rows) = x, y
    numbers = [cell.value for cell in cells.values() if cell.value is not None]
    low, high = min(numbers, default=0.0), max(numbers, default=1.0)
    with drawing():
        figure = Figure(figsize=(2.0 + 1.05 * len(columns), 1.6 + 0.62 * len(rows)), layout="constrained")
        axes = figure.add_subplot()
        for column, each_x in enumerate(columns):
            for row, each_y in enumerate(rows):
                cell = cells.get((each_x, each_y), HeatMapCell(None))
                share = 0.0 if cell.value is None or high == low else (cell.value - low) / (high - low)
                color = NOTHING if cell.value is None else colormaps["Blues"](0.08 + 0.52 * share)
                axes.add_patch(
                    Rectangle(
                        (column - 0.47, row - 0.45), 0.94, 0.9, facecolor=color,
                        edgecolor=WRONG if cell.wrong else "none", linewidth=1.8,
                    )
                )  # fmt: skip
                shown = "–" if cell.value is None else f"{cell.value:g}"
                axes.text(
                    column, row + (0.12 if cell.wrong else 0), shown, ha="center", va="center", color=INK
                )
                if cell.wrong:
                    word = cell.wrong if len(cell.wrong) <= _WORD else f"{cell.wrong[: _WORD - 1]}…"
                    axes.text(column, row - 0.24, word, ha="center", va="center", color=WRONG, fontsize=7)
        axes.set(xlim=(-0.55, len(columns) - 0.45), ylim=(-0.55, len(rows) - 0.45), xlabel=along, ylabel=up)
        axes.set_xticks(range(len(columns)), columns)
        axes.set_yticks(range(len(rows)), rows)
        axes.tick_params(length=0, colors=MUTED)
        axes.spines[:].set_visible(False)
        wrong = sum(bool(cell.wrong) for cell in cells.values())
        axes.set_title(f"{title}: {len(cells) - wrong} of {len(cells)} combinations hold", loc="left")
    return figure
