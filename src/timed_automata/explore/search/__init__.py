"""Searches over symbolic states: reachability, deadlocks, lassos, and concrete runs for their results."""

from ._concrete import Ending, Leg, NoRunError, Timing, anywhere, concrete
from ._conditions import Only, Within, ZoneCondition
from ._cycles import components, shortest_cycle
from ._deadlock import MOST_DOUBTS, Deadlocks
from ._liveness import Lasso, LassoSearch, Start
from ._reach import OutOfRangeError, Progress, Search, WidestFirst, without_collector
from ._stages import SearchNode, Stage
