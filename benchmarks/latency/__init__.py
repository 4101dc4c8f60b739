"""Latencies of the product against the testbench, and of the floor beside it."""

from ._blocks import FULL, QUICK, Plan
from ._measure import measure
from ._result import Result

__all__ = ["FULL", "QUICK", "Plan", "Result", "measure"]
