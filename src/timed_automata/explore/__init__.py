"""Exploration of networks of timed automata by zones: queries, worst cases, and what every model must satisfy."""

from timed_automata._trace import Trace, TraceStep

from ._bounded import relaxed
from ._coverage_report import CoverageReport
from ._explorer import Explorer, RunTimeError, check
from ._formula import Case, Data, Formula, compile_clock, compile_formula, compile_integer
from ._overview import Overview, overview
from ._query import Query, parse_query
from ._sanity import SanityReport
from ._verdict import Extreme, Verdict

__all__ = [
    "Case",
    "CoverageReport",
    "Data",
    "Explorer",
    "Extreme",
    "Formula",
    "Overview",
    "Query",
    "RunTimeError",
    "SanityReport",
    "Trace",
    "TraceStep",
    "Verdict",
    "check",
    "compile_clock",
    "compile_formula",
    "compile_integer",
    "overview",
    "parse_query",
    "relaxed",
]
