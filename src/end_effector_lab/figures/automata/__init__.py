"""Templates drawn as in Fig. 5 of the paper."""

from ._figure import draw_template
