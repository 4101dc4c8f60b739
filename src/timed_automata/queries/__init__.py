"""UPPAAL's requirement language: queries as text, and their conditions over data and clocks."""

from ._condition_filter import ConditionFilter
from ._first_hit_watch import FirstHitWatch
from ._formula import (
    All,
    Case,
    Comparison,
    Data,
    Formula,
    Some,
    compile_clock,
    compile_formula,
    compile_integer,
    compile_without_deadlock,
    mentions_deadlock,
)
from ._query import Query, parse_query
from ._query_names import location_of

__all__ = [
    "All",
    "Case",
    "Comparison",
    "ConditionFilter",
    "Data",
    "FirstHitWatch",
    "Formula",
    "Query",
    "Some",
    "compile_clock",
    "compile_formula",
    "compile_integer",
    "compile_without_deadlock",
    "location_of",
    "mentions_deadlock",
    "parse_query",
]
