"""Why a run refutes a query: in words, with the names of constants, and what the query speaks of over the run."""

from ._explain import Explanation, explain, explain_time
from ._names import Names
from ._watched import WatchedClock, WatchedState

__all__ = ["Explanation", "Names", "WatchedClock", "WatchedState", "explain", "explain_time"]
