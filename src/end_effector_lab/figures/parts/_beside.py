"""Text at the right of a plot, near the height of its value, without overlaps."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from end_effector_lab.figures._labels import height_of, spread

BESIDE_SIZE = 9.0
"""Size of this text, points."""


def write_beside(axes: Axes, labels: Sequence[tuple[float, str, str]], height_in: float) -> None:
    """Write ``(value, text, colour)`` beside the plot, whose limits are set; a text may have several lines.

    Args:
        axes: the plot.
        labels: the texts, at values of the plot's y axis.
        height_in: height of the plot, inches.
    """
    low, high = axes.get_ylim()
    heights = [
        height_of(BESIDE_SIZE) * (text.count("\n") + 1) * (high - low) / height_in for _, text, _ in labels
    ]
    places = spread([at for at, _, _ in labels], heights, low, high)
    for place, (_, text, colour) in zip(places, labels, strict=True):
        axes.annotate(
            text,
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            color=colour,
            fontsize=BESIDE_SIZE,
            va="center",
            linespacing=1.15,
            annotation_clip=False,
        )
