"""The figures of runs, of automata and of grids of numbers; matplotlib is imported only when one is drawn."""

from ._draw import (
    STYLES,
    HeatMapCell,
    RecordedRun,
    draw_template,
    heat_map,
    overlay,
    paper,
    save,
    timeline,
    tuning,
    what_if,
)

__all__ = [
    "STYLES",
    "HeatMapCell",
    "RecordedRun",
    "draw_template",
    "heat_map",
    "overlay",
    "paper",
    "save",
    "timeline",
    "tuning",
    "what_if",
]
