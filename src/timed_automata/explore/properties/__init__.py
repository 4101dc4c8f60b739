"""The properties that are decided by searches: queries, worst cases, coverage, divergence of time."""

from ._coverage_report import CoverageReport, coverage_report, open_channels
from ._extremes import FoundExtreme, extreme_clock, extreme_integer
from ._reachability import Reachability, answer, reachability, timelock
from ._responses import BoundedResponse, LeadsTo, bounded, relaxed
from ._verdict import Extreme, Verdict
from ._zeno import taken, zeno_cycle, zeno_run

__all__ = [
    "BoundedResponse",
    "CoverageReport",
    "Extreme",
    "FoundExtreme",
    "LeadsTo",
    "Reachability",
    "Verdict",
    "answer",
    "bounded",
    "coverage_report",
    "extreme_clock",
    "extreme_integer",
    "open_channels",
    "reachability",
    "relaxed",
    "taken",
    "timelock",
    "zeno_cycle",
    "zeno_run",
]
