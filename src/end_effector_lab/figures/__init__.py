"""The figures of runs and of automata; matplotlib is imported only when one is drawn."""

from ._draw import (
    STYLES,
    RecordedRun,
    draw_template,
    overlay,
    paper,
    save,
    timeline,
    tuning,
    what_if,
)

__all__ = [
    "STYLES",
    "RecordedRun",
    "draw_template",
    "overlay",
    "paper",
    "save",
    "timeline",
    "tuning",
    "what_if",
]
