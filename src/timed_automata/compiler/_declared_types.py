"""Resolves declarations: the type with computed bounds and sizes, and the scalars of an initialiser."""

from __future__ import annotations

from dataclasses import replace

from timed_automata._limits import ELEMENTS
from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._scope import Alias
from timed_automata.compiler._types import BOOL, INT, VOID, Dimension, Type
from timed_automata.compiler._values import WIDE
from timed_automata.document import did_you_mean, fault, refused
from timed_automata.language import ast

_PLAIN = {"int": INT, "bool": BOOL, "void": VOID, "clock": Type("clock"), "chan": Type("chan")}


def resolve_type(expressions: Expressions, node: ast.TypeName) -> Type:
    """Return the type without the dimensions that follow the declared name."""
    if node.low is not None and node.high is not None:
        low, high = expressions.bounds(node)
        if low > high:
            raise fault(node.span, f"'{node.span.snippet}' is empty: {low} is more than {high}.")
        type_ = Type("int", low, high)
    elif node.base == "scalar" and node.high is not None:
        type_ = Type("int", 0, _size(expressions, node.high, "a scalar set") - 1)
    elif node.fields:
        type_ = _structure(expressions, node)
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
    for prefix in ("const", "meta"):
        if prefix in node.prefixes and not type_.integral:
            raise fault(node.span, f"'{prefix}' belongs to int and bool, not to {type_}.")
    return replace(
        type_,
        constant=type_.constant or "const" in node.prefixes,
        broadcast=type_.broadcast or "broadcast" in node.prefixes,
        urgent=type_.urgent or "urgent" in node.prefixes,
    )


def _structure(expressions: Expressions, node: ast.TypeName) -> Type:
    fields: dict[str, Type] = {}
    for declared in node.fields:
        base = resolve_type(expressions, declared.type)
        for declarator in declared.declarators:
            name, type_ = declarator.name, resolve_dimensions(expressions, base, declarator)
            if name in fields:
                raise fault(declarator.span, f"The structure has two fields '{name}'.")
            if not type_.integral:
                what = f"'{name}', {type_} in a structure"
                raise refused(declarator.span, what, "Declare it outside, as an array if there are several.")
            fields[name] = type_
    return Type.structure(tuple(fields.items()))


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
    return Dimension(0, _size(expressions, node, "an array") - 1)


def _size(expressions: Expressions, node: ast.Expression, what: str) -> int:
    size = expressions.constant(node, f"The size of {what}")
    if size < 1:
        raise fault(node.span, f"The size of {what} is {size}.", "Expected at least one element.")
    return size


def flatten(node: ast.Expression, type_: Type, name: str) -> list[ast.Expression]:
    """Return the scalars of an initialiser in the order of their places.

    Raises:
        ModelError: its shape differs from that of the type.
    """
    if type_.single:
        if isinstance(node, ast.Braces):
            raise fault(node.span, f"Braces where '{name}' has a single value.", "Remove them.")
        return [node]
    parts = type_.parts
    if not isinstance(node, ast.Braces):
        what = f"an array of {len(parts)}" if type_.dimensions else f"a structure of {len(parts)}"
        raise fault(node.span, f"'{name}' is {what}.", "Expected {…}.")
    items = _in_order(node, type_, name)
    if len(items) != len(parts):
        todo = "Was a size changed without the values that depend on it?"
        raise fault(node.span, f"'{name}' needs {len(parts)} values, not {len(items)}.", todo)
    return [
        scalar
        for item, (_, part) in zip(items, parts, strict=True)
        for scalar in (
            flatten(item, part, name)
            if part.single or isinstance(item, ast.Braces)
            else _of_whole(item, part)
        )
    ]


def _in_order(node: ast.Braces, type_: Type, name: str) -> tuple[ast.Expression, ...]:
    """Return the items of braces in the order of the fields, by which they may be named."""
    if not any(node.names):
        return node.items
    fields = [] if type_.dimensions else [field for field, _ in type_.fields]
    if sorted(map(str, node.names)) != sorted(fields):
        what = f"'{name}' has the fields {', '.join(fields)}." if fields else f"'{name}' has no fields."
        raise fault(node.span, what, "Name each field once, or none.")
    named = dict(zip(node.names, node.items, strict=True))
    return tuple(named[field] for field in fields)


def _of_whole(node: ast.Expression, type_: Type) -> list[ast.Expression]:
    """Return the scalars of an array or a structure that is one item of an initialiser."""
    if any(isinstance(each, ast.Call | ast.Assignment | ast.Increment) for each in ast.walk(node)):
        raise refused(
            node.span, f"'{node.span.snippet}', a call for a part of an initialiser", "Assign it later."
        )
    if type_.single:
        return [node]
    if type_.dimensions:
        low, high = type_.dimensions[0]
        inside: list[ast.Expression] = [
            ast.Index(node.span, node, ast.Number(node.span, index)) for index in range(low, high + 1)
        ]
    else:
        inside = [ast.Member(node.span, node, name) for name, _ in type_.fields]
    return [
        scalar
        for each, (_, part) in zip(inside, type_.parts, strict=True)
        for scalar in _of_whole(each, part)
    ]
