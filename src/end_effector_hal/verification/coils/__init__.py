"""Outputs of two coils: a network of their own, and what that of the tool may assume of them."""

from ._coils import COILS_FILE, coil_constants, coil_networks, prove_tool
