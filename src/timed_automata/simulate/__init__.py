"""Concrete runs of a whole network, as in UPPAAL's simulator: random or guided, in exact time."""

from ._choice import Choice, parse_choices
from ._machine import Machine, Option
from ._run import Chooser, Run, simulate

__all__ = ["Choice", "Chooser", "Machine", "Option", "Run", "parse_choices", "simulate"]
