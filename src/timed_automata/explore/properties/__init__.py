"""Properties that searches decide: queries, worst cases, coverage, divergence of time."""

from ._coverage_report import Coverage, CoverageReport, open_channels
from ._extremes import FoundExtreme, extreme_clock, extreme_integer
from ._reachability import Reachability, answer, reachability, timelock
from ._responses import BoundedResponse, LeadsTo, bounded, relaxed
from ._room import ReactionBound, Room
from ._verdict import Extreme, Verdict
from ._zeno import taken, zeno_cycle, zeno_run
