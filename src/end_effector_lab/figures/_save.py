"""Functions that write figures to files; the same figure gives the same bytes."""

from __future__ import annotations

import os
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from end_effector_hal.errors import UsageError

from ._style import drawing

DPI = 120


def save(figure: Figure, path: str | Path) -> Path:
    """Save as PNG or SVG, by the suffix, completely or not at all; the same figure gives the same bytes.

    Raises UsageError.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (".png", ".svg"):
        raise UsageError(
            f"{path.name!r} is neither .png nor .svg.", where=str(path), todo="Choose one of these."
        )
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with drawing(), beside.open("wb") as file:
            if suffix == ".png":
                FigureCanvasAgg(figure)
                figure.savefig(file, format="png", metadata={"Software": "end-effector-hal"})
            else:
                FigureCanvasSVG(figure)
                figure.savefig(file, format="svg", metadata={"Date": None, "Creator": "end-effector-hal"})
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise UsageError(f"The figure cannot be written: {error.strerror}.", where=str(path)) from None
    return path
