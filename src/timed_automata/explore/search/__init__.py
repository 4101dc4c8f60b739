"""Searches over symbolic states: reachability, deadlocks, lassos, and concrete runs of what is found."""

from ._collector import without_collector
from ._components import components
from ._concrete import Ending, Leg, NoRunError, concrete
from ._deadlock import MOST_DOUBTS, Deadlocks
from ._deadlock_free import DeadlockFree
from ._delay import Only, Within
from ._liveness import Lasso, LassoSearch, Start
from ._reach import OutOfRangeError, Progress, Search, SearchNode
from ._widest_first import WidestFirst
from ._zone_condition import ZoneCondition

__all__ = [
    "MOST_DOUBTS",
    "DeadlockFree",
    "Deadlocks",
    "Ending",
    "Lasso",
    "LassoSearch",
    "Leg",
    "NoRunError",
    "Only",
    "OutOfRangeError",
    "Progress",
    "Search",
    "SearchNode",
    "Start",
    "WidestFirst",
    "Within",
    "ZoneCondition",
    "components",
    "concrete",
    "without_collector",
]
