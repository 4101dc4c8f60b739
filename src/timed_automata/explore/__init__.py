"""Explores networks with zones: answers queries, finds worst cases, and checks what every model must satisfy."""

from ._explorer import Explorer, RunTimeError, verify
from ._overview import Overview, overview
from .properties._coverage_report import CoverageReport
from .properties._responses import relaxed
from .properties._room import ReactionBound
from .properties._verdict import Extreme, Verdict

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
