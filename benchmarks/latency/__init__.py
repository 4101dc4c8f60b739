"""Latencies of the product against the testbench, and of the floor beside it."""

from ._core import measure_core
from ._plan import FULL, QUICK, Plan
from ._result import Result
from ._ros import measure_ros

__all__ = ["FULL", "QUICK", "Plan", "Result", "measure_core", "measure_ros"]
