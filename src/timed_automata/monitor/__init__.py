"""Whether what happened is a run of the network: the third user of the one semantics."""

from ._monitor import Monitor, Objection

__all__ = ["Monitor", "Objection"]
