"""Exploration of networks of timed automata by zones: queries, worst cases, and what every model must satisfy."""

from end_effector_hal.automata.explore._bounded import relaxed
from end_effector_hal.automata.explore._coverage import Coverage
from end_effector_hal.automata.explore._explorer import Explorer, RunTimeError, check, explore_all, worst_case
from end_effector_hal.automata.explore._happened import Missing
from end_effector_hal.automata.explore._overview import Overview, overview
from end_effector_hal.automata.explore._query import Query, parse_query
from end_effector_hal.automata.explore._trace import Trace, TraceStep
from end_effector_hal.automata.explore._verdict import Extreme, Verdict

__all__ = [
    "Coverage",
    "Explorer",
    "Extreme",
    "Missing",
    "Overview",
    "Query",
    "RunTimeError",
    "Trace",
    "TraceStep",
    "Verdict",
    "check",
    "explore_all",
    "overview",
    "parse_query",
    "relaxed",
    "worst_case",
]
