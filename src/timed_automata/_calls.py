"""Calls of functions: numbers and arrays by value, variables and arrays by reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

from timed_automata import _ast as ast
from timed_automata._faults import fault, refused
from timed_automata._scope import FormalParameter, Function
from timed_automata._values import Place, Value

if TYPE_CHECKING:
    from timed_automata._expressions import Expressions


def call_source(expressions: Expressions, node: ast.Call, function: Function) -> str:
    """Source of a call.

    Raises:
        ModelError: the arguments are not those that the function takes.
    """
    expected, found = len(function.parameters), len(node.arguments)
    if expected != found:
        raise fault(node.span, f"'{function.name}' takes {expected} arguments, not {found}.")
    arguments = ["v", "r"]
    for parameter, argument in zip(function.parameters, node.arguments, strict=True):
        what = f"parameter '{parameter.name}' of '{function.name}'"
        if parameter.reference or parameter.type.dimensions:
            arguments.append(_place(expressions, parameter, argument, what))
        else:
            value = expressions.value(argument)
            arguments.append(expressions.checked(value, parameter.type, argument.span, what))
    expressions.repeated(function.effects.repeats, node.span)
    expressions.effects.add(function.effects)
    return f"{function.python}({', '.join(arguments)})"


def _place(expressions: Expressions, parameter: FormalParameter, node: ast.Expression, what: str) -> str:
    term = expressions.term(node)
    if isinstance(term, Value) and parameter.reference and term.known is None and isinstance(node, ast.Name):
        construct = f"'{node.name}', a scalar of a function passed by reference"
        raise refused(node.span, construct, "Return a value instead.")
    expected = parameter.type
    if not isinstance(term, Place) or term.type.shape != expected.shape:
        found = term.type if not isinstance(term, Value) else "a number"
        raise fault(node.span, f"'{node.span.snippet}' is {found}.", f"The {what} is {expected}.")
    same = (term.type.kind, term.type.low, term.type.high) == (expected.kind, expected.low, expected.high)
    if not same and not expected.constant:
        raise fault(node.span, f"'{node.span.snippet}' is {term.type}.", f"The {what} is {expected}.")
    expressions.read(term.storage)
    if not parameter.reference:
        return term.slice
    if not expected.constant:
        expressions.write(term.storage, node.span)
    return f"{term.storage.container}, {term.start}"
