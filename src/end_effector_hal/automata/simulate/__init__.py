"""Concrete runs of a whole network, as in UPPAAL's simulator: random or guided, in exact time."""

from end_effector_hal.automata.simulate._choice import Choice, parse_choices
from end_effector_hal.automata.simulate._machine import Machine, Option
from end_effector_hal.automata.simulate._run import Chooser, Run, simulate

__all__ = ["Choice", "Chooser", "Machine", "Option", "Run", "parse_choices", "simulate"]
