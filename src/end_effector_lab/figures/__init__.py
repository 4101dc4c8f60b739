"""The figures of runs, of automata and of grids of numbers; matplotlib is imported only when one is drawn."""

from ._draw import (
    draw_template,
    heat_map,
    overlay,
    paper,
    save,
    timeline,
    tuning,
    what_if,
)
from ._heat_map_cell import HeatMapCell
from ._recorded_run import STYLES, RecordedRun

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
