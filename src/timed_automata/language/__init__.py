"""UPPAAL's language: grammar, syntax tree and parser."""

from . import ast
from ._parts import (
    parse_declarations,
    parse_expression,
    parse_instantiations,
    parse_parameters,
    parse_selects,
    parse_synchronisation,
    parse_system,
    parse_updates,
)
from ._walk import walk

__all__ = [
    "ast",
    "parse_declarations",
    "parse_expression",
    "parse_instantiations",
    "parse_parameters",
    "parse_selects",
    "parse_synchronisation",
    "parse_system",
    "parse_updates",
    "walk",
]
