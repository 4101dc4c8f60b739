"""Whether what happened is a run of the network: the third user of the one semantics."""

from ._monitor import Monitor
from ._monitored_query import MonitoredQuery, monitored_queries
from ._objection import Objection

__all__ = ["Monitor", "MonitoredQuery", "Objection", "monitored_queries"]
