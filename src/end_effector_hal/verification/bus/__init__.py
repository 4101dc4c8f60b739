"""Outputs that are registers: a network of their own, and what that of the tool may assume of them."""

from ._bus_output import BUS_FILE, bus_networks, output_constants
