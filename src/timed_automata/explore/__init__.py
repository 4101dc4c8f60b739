"""Exploration of networks of timed automata by zones: queries, worst cases, and what every model must satisfy."""

from ._bounded import relaxed
from ._coverage import Coverage
from ._explorer import Explorer, RunTimeError, check, explore_all, worst_case
from ._formula import Case, Data, Formula, compile_clock, compile_formula, compile_integer
from ._happened import Missing
from ._overview import Overview, overview
from ._query import Query, parse_query
from ._trace import Trace, TraceStep
from ._verdict import Extreme, Verdict

__all__ = [
    "Case",
    "Coverage",
    "Data",
    "Explorer",
    "Extreme",
    "Formula",
    "Missing",
    "Overview",
    "Query",
    "RunTimeError",
    "Trace",
    "TraceStep",
    "Verdict",
    "check",
    "compile_clock",
    "compile_formula",
    "compile_integer",
    "explore_all",
    "overview",
    "parse_query",
    "relaxed",
    "worst_case",
]
