"""Time, states and memory of the verification."""

from ._measure import Measured, measure_verification
from ._plan import FULL, QUICK, Plan
from ._subject import Answer, Subject

__all__ = ["FULL", "QUICK", "Answer", "Measured", "Plan", "Subject", "measure_verification"]
