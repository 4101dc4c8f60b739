"""Searches over symbolic states: reachability, deadlocks, lassos, and concrete runs for their results."""

from ._concrete import Timing
from ._reach import Search, without_collector
