"""Compares two networks: whether an edit changes what can happen."""

from ._equivalence import ReachedNetwork

__all__ = ["ReachedNetwork"]
