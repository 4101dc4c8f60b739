"""The figures of runs and of automata; matplotlib is imported only when one is drawn."""

from ._draw import paper, save, timeline
from .automata import draw_template

__all__ = ["draw_template", "paper", "save", "timeline"]
