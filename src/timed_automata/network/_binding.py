"""Giving the parameters of a template their arguments."""

from __future__ import annotations

from timed_automata.compiler import (
    ChannelSymbol,
    ClockSymbol,
    Constant,
    Expressions,
    GeneratedCode,
    IndexedTerm,
    Scope,
    Storage,
    StorageTerm,
    Symbol,
    Term,
    Type,
    resolve_dimensions,
    resolve_type,
)
from timed_automata.document import fault
from timed_automata.language import ast


def bind(
    code: GeneratedCode, parameter: ast.Parameter, argument: ast.Expression, caller: Scope, scope: Scope
) -> None:
    """Declare a parameter in ``scope``: a constant by value, another name for what is passed by reference.

    Raises:
        ModelError: the argument is of another type, not constant, or out of range.
    """
    inner, outer = Expressions(code, scope), Expressions(code, caller)
    name = parameter.declarator.name
    type_ = resolve_dimensions(inner, resolve_type(inner, parameter.type), parameter.declarator)
    if parameter.reference:
        symbol = _reference(outer, argument, name, type_)
    elif not type_.integral:
        todo = f"Write '{type_.scalar} &{name}'."
        raise fault(parameter.span, f"The parameter '{name}' is a {type_.kind} by value.", todo)
    else:
        symbol = _constant(outer, argument, name, type_)
    scope.declare(name, symbol, parameter.span)


def _constant(outer: Expressions, argument: ast.Expression, name: str, type_: Type) -> Constant:
    values: tuple[int, ...]
    if type_.dimensions:
        term = outer.term(argument)
        constant = isinstance(term, StorageTerm) and term.values is not None and not term.computed
        if not isinstance(term, StorageTerm) or not constant or term.type.shape != type_.shape:
            raise fault(argument.span, f"'{argument.span.snippet}' is no constant {type_}.")
        values = _elements(term)
    else:
        number = outer.constant(argument, f"The argument for '{name}'")
        values = (int(number != 0) if type_.kind == "bool" else number,)
    if not all(type_.low <= value <= type_.high for value in values):
        raise fault(argument.span, f"{name} = {argument.span.snippet} is out of its range {type_}.")
    return Constant(name, type_, values, outer.code.constant(values) if type_.dimensions else "")


def _elements(term: StorageTerm) -> tuple[int, ...]:
    return (term.values or ())[term.offset : term.offset + term.type.size]


def _reference(outer: Expressions, argument: ast.Expression, name: str, expected: Type) -> Symbol:
    term = outer.term(argument)
    if not isinstance(term, StorageTerm | IndexedTerm) or term.computed or not _fits(term, expected):
        found = term.type if isinstance(term, StorageTerm | IndexedTerm) else "a number"
        raise fault(argument.span, f"'{argument.span.snippet}' is {found}.", f"'{name}' is {expected}.")
    if isinstance(term, IndexedTerm):
        kind = ClockSymbol if expected.kind == "clock" else ChannelSymbol
        return kind(term.name, term.type, term.base + term.offset)
    if term.values is not None:
        if not expected.constant:
            raise fault(
                argument.span, f"'{argument.span.snippet}' is constant, but '{name}' may be assigned."
            )
        values = _elements(term)
        return Constant(name, expected, values, outer.code.constant(values))
    storage = term.storage
    assert isinstance(storage.base, int)  # outside of functions
    written = storage.written and not expected.constant
    return Storage(storage.name, term.type, "v", storage.base + term.offset, written)


def _fits(term: Term, expected: Type) -> bool:
    if not isinstance(term, StorageTerm | IndexedTerm):
        return False
    found = term.type
    if (found.kind, found.shape) != (expected.kind, expected.shape):
        return False
    if expected.kind == "chan":
        return (found.broadcast, found.urgent) == (expected.broadcast, expected.urgent)
    return expected.constant or (found.low, found.high) == (expected.low, expected.high)
