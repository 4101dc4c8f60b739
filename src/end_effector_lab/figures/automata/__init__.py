"""Templates drawn as in Fig. 5 of the paper; matplotlib is imported only when one is drawn."""

from ._template import draw_template

__all__ = ["draw_template"]
