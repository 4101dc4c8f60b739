"""Type-checks the syntax tree and compiles it to Python: expressions, guards, updates, functions."""

from ._conditions import (
    CONTRARY,
    Bound,
    ClockConstraint,
    Condition,
    Quantity,
    Values,
    clock_constraint,
    clock_term,
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
from ._statements import Statements, Updates
from ._types import Type
from ._values import COMPARISONS, IndexedTerm, StorageTerm, Term, Value
