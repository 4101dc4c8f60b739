"""Whether what happened is a run of the network: the third user of the one semantics."""

from ._monitor import Monitor
from ._objection import Objection
from ._watched import Watched, watched_queries

__all__ = ["Monitor", "Objection", "Watched", "watched_queries"]
