"""Smaller proofs in addition to that of a tool: bus outputs, two coils, process deaths at any time, and Fig. 5."""

from ._coils import COILS_FILE, coil_constants, coil_networks, prove_tool
from ._fig5 import FIG5_FILE, OBSERVED, Fig5Report, compare_with_fig5, fig5_network, grips_as_fig5
from ._networks import BUS_FILE, DEATHS_FILE, bus_networks, death_network, output_constants
