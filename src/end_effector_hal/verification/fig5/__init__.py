"""The paper's Fig. 5 in its own size, and whether the automata of a tool do on its events only what it does."""

from ._fig5 import FIG5_FILE, OBSERVED, Fig5Report, compare_with_fig5, fig5_network, grips_as_fig5
