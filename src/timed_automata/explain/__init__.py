"""Explains why a run refutes a query: in words, with names of constants, and with the query's subjects over the run."""

from ._explain import Explanation, explain, explain_time
from ._names import Names
from ._watched import WatchedClock, WatchedState

__all__ = ["Explanation", "Names", "WatchedClock", "WatchedState", "explain", "explain_time"]
