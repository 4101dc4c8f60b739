"""UPPAAL's query language: parses queries, and compiles their conditions over data and clocks."""

from ._compile import (
    bounds_of,
    called,
    compile_clock,
    compile_formula,
    compile_integer,
    compile_without_deadlock,
    location_of,
)
from ._formula import All, Case, Comparison, ConditionFilter, Data, Formula, Some, mentions_deadlock
from ._query import Query, parse_query

__all__ = [
    "All",
    "Case",
    "Comparison",
    "ConditionFilter",
    "Data",
    "Formula",
    "Query",
    "Some",
    "bounds_of",
    "called",
    "compile_clock",
    "compile_formula",
    "compile_integer",
    "compile_without_deadlock",
    "location_of",
    "mentions_deadlock",
    "parse_query",
]
