"""Judges whether recorded events are a run of the network; uses the same semantics as execution and exploration."""

from ._monitor import Monitor, Objection

__all__ = ["Monitor", "Objection"]
