"""Benchmarks of the verification: time, states and memory."""

from ._measure import FULL, QUICK, Measured, Plan, measure_verification
from ._subject import Answer, Subject

__all__ = ["FULL", "QUICK", "Answer", "Measured", "Plan", "Subject", "measure_verification"]
