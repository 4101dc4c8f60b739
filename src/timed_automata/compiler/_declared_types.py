"""Resolves declarations: the type with computed bounds and sizes, and the scalars of an initialiser."""

from __future__ import annotations

from dataclasses import replace

from timed_automata._limits import ELEMENTS
from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._scope import Alias
from timed_automata.compiler._types import BOOL, INT, VOID, Dimension, Type
from timed_automata.compiler._values import WIDE
from timed_automata.document import did_you_mean, fault
from timed_automata.language import ast

_PLAIN = {"int": INT, "bool": BOOL, "void": VOID, "clock": Type("clock"), "chan": Type("chan")}


def resolve_type(expressions: Expressions, node: ast.TypeName) -> Type:
    """Return the type without the dimensions that follow the declared name."""
    if node.low is not None and node.high is not None:
        low, high = expressions.bounds(node)
        if low > high:
            raise fault(node.span, f"'{node.span.snippet}' is empty: {low} is more than {high}.")
        type_ = Type("int", low, high)
    elif node.base in _PLAIN:
        type_ = _PLAIN[node.base]
    else:
        symbol = expressions.scope.find(node.base)
        if not isinstance(symbol, Alias):
            known = [name for name in expressions.scope if isinstance(expressions.scope.find(name), Alias)]
            raise fault(node.span, f"'{node.base}' is no type.", did_you_mean(node.base, [*known, *_PLAIN]))
        type_ = replace(symbol.type, name=node.base)
    if "const" in node.prefixes and type_ == INT:
        type_ = Type("int", -WIDE, WIDE - 1)  # UPPAAL bounds the default range of variables only
    channel = type_.kind == "chan"
    for prefix in ("urgent", "broadcast"):
        if prefix in node.prefixes and not channel:
            raise fault(node.span, f"'{prefix}' belongs to channels, not to {type_}.")
    if "const" in node.prefixes and not type_.integral:
        raise fault(node.span, f"'const' belongs to int and bool, not to {type_}.")
    return replace(
        type_,
        constant=type_.constant or "const" in node.prefixes,
        broadcast=type_.broadcast or "broadcast" in node.prefixes,
        urgent=type_.urgent or "urgent" in node.prefixes,
    )


def resolve_dimensions(expressions: Expressions, base: Type, node: ast.Declarator) -> Type:
    """Return the type of a declared name: the declaration's type with the name's own dimensions before it."""
    if base.kind == "void":
        raise fault(node.span, f"'{node.name}' cannot be void.")
    dimensions = [_dimension(expressions, dimension) for dimension in node.dimensions]
    type_ = replace(base, dimensions=(*dimensions, *base.dimensions))
    if type_.size > ELEMENTS:
        raise fault(node.span, f"'{node.name}' has {type_.size} elements, more than {ELEMENTS}.")
    expressions.code.elements += type_.size
    if expressions.code.elements > ELEMENTS:
        raise fault(node.span, f"With '{node.name}' more than {ELEMENTS} elements are declared.")
    return type_


def _dimension(expressions: Expressions, node: ast.Expression | ast.TypeName) -> Dimension:
    if isinstance(node, ast.TypeName):
        return Dimension(*expressions.bounds(node))
    if isinstance(node, ast.Name):
        symbol = expressions.scope.get(node.name, node.span)
        if isinstance(symbol, Alias):
            return Dimension(*expressions.bounds(ast.TypeName(node.span, node.name)))
    size = expressions.constant(node, "The size of an array")
    if size < 1:
        raise fault(node.span, f"The size of an array is {size}.", "Expected at least one element.")
    return Dimension(0, size - 1)


def flatten(node: ast.Expression, type_: Type, name: str) -> list[ast.Expression]:
    """Return the scalars of an initialiser in row-major order.

    Raises:
        ModelError: its shape differs from that of the type.
    """
    if not type_.dimensions:
        if isinstance(node, ast.Braces):
            raise fault(node.span, f"Braces where '{name}' has a single value.", "Remove them.")
        return [node]
    size = type_.dimensions[0].size
    if not isinstance(node, ast.Braces):
        raise fault(node.span, f"'{name}' is an array of {size}.", "Expected {…}.")
    if len(node.items) != size:
        todo = "Was a size changed without the values that depend on it?"
        raise fault(node.span, f"'{name}' needs {size} values, not {len(node.items)}.", todo)
    return [scalar for item in node.items for scalar in flatten(item, type_.element, name)]
