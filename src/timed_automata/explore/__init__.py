"""Explores networks with zones: answers queries, finds worst cases, and checks what every model must satisfy."""

from ._explorer import Explorer, RunTimeError, verify
from ._overview import Overview, overview
from .properties import CoverageReport, Extreme, ReactionBound, Verdict, relaxed

__all__ = [
    "CoverageReport",
    "Explorer",
    "Extreme",
    "Overview",
    "ReactionBound",
    "RunTimeError",
    "Verdict",
    "overview",
    "relaxed",
    "verify",
]
