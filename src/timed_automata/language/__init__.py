"""UPPAAL's language: grammar, syntax tree and parser."""

from . import ast
from ._parts import (
    names_in,
    parse_cache,
    parse_declarations,
    parse_expression,
    parse_instantiations,
    parse_name,
    parse_parameters,
    parse_selects,
    parse_synchronisation,
    parse_system,
    parse_updates,
    parsing_with,
)
