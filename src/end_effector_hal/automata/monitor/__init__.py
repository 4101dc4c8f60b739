"""Whether what happened is a run of the network: the third user of the one semantics."""

from end_effector_hal.automata.monitor._monitor import Monitor
from end_effector_hal.automata.monitor._objection import Objection
from end_effector_hal.automata.monitor._watched import Watched, watched_queries

__all__ = ["Monitor", "Objection", "Watched", "watched_queries"]
