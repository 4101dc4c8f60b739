"""Type-checks the syntax tree and compiles it to Python: expressions, guards, updates, functions."""

from ._conditions import (
    Bound,
    ClockConstraint,
    Condition,
    Quantity,
    Relation,
    Values,
    compile_condition,
    number_of,
)
from ._declared_types import flatten, resolve_dimensions, resolve_type
from ._expressions import Expressions
from ._generated_code import GeneratedCode
from ._scope import (
    Alias,
    ChannelSymbol,
    ClockSymbol,
    Constant,
    Effects,
    FormalParameter,
    Function,
    Local,
    Scope,
    Storage,
    Symbol,
)
from ._statements import Statements
from ._terms import IndexedTerm, StorageTerm, Term
from ._types import Type
from ._updates import Updates
from ._values import Value

__all__ = [
    "Alias",
    "Bound",
    "ChannelSymbol",
    "ClockConstraint",
    "ClockSymbol",
    "Condition",
    "Constant",
    "Effects",
    "Expressions",
    "FormalParameter",
    "Function",
    "GeneratedCode",
    "IndexedTerm",
    "Local",
    "Quantity",
    "Relation",
    "Scope",
    "Statements",
    "Storage",
    "StorageTerm",
    "Symbol",
    "Term",
    "Type",
    "Updates",
    "Value",
    "Values",
    "compile_condition",
    "flatten",
    "number_of",
    "resolve_dimensions",
    "resolve_type",
]
