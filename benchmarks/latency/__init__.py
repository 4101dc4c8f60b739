"""Benchmarks of the latencies of the product with the testbench, and of the floor."""

from ._blocks import CYCLE_S, FULL, LONGEST_S, QUICK, Plan, Tail, read
from ._driven import Driven
from ._hardware import Hardware
from ._matching import Latencies, MatchError, product_latencies
from ._measure import measure
from ._result import Result

__all__ = [
    "CYCLE_S",
    "FULL",
    "LONGEST_S",
    "QUICK",
    "Driven",
    "Hardware",
    "Latencies",
    "MatchError",
    "Plan",
    "Result",
    "Tail",
    "measure",
    "product_latencies",
    "read",
]
