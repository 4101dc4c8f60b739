"""Concrete runs of a whole network, as in UPPAAL's simulator: random or guided, in exact time."""

from ._machine import Choice, Machine, Option, parse_choices
from ._run import Chooser, Run, simulate

__all__ = ["Choice", "Chooser", "Machine", "Option", "Run", "parse_choices", "simulate"]
