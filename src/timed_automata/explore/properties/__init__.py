"""The properties that are decided by searches: queries, worst cases, coverage, divergence of time."""

from ._bounded import BoundedResponse, bounded, relaxed
from ._coverage_report import CoverageReport, coverage_report, open_channels
from ._divergence import Timelocks, taken, zeno_run
from ._extremes import FoundExtreme, extreme_clock, extreme_integer
from ._leads_to import LeadsTo
from ._reachability import Reachability, answer
from ._sanity import SanityReport, sanity_of
from ._verdict import Extreme, Verdict
from ._zeno import zeno_cycle

__all__ = [
    "BoundedResponse",
    "CoverageReport",
    "Extreme",
    "FoundExtreme",
    "LeadsTo",
    "Reachability",
    "SanityReport",
    "Timelocks",
    "Verdict",
    "answer",
    "bounded",
    "coverage_report",
    "extreme_clock",
    "extreme_integer",
    "open_channels",
    "relaxed",
    "sanity_of",
    "taken",
    "zeno_cycle",
    "zeno_run",
]
