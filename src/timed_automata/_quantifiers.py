"""``forall``, ``exists`` and ``sum`` over a bounded type."""

from __future__ import annotations

from typing import TYPE_CHECKING

from timed_automata import _ast as ast
from timed_automata._scope import Local, Scope
from timed_automata._types import Type
from timed_automata._values import Value

if TYPE_CHECKING:
    from timed_automata._expressions import Expressions

_UNROLL = 8  # over at most so many values they become plain code, which is faster


def quantified(expressions: Expressions, node: ast.Quantified) -> Value:
    """A quantifier or a sum."""
    low, high = expressions.bounds(node.type)
    count = high - low + 1
    if count <= _UNROLL:
        return unrolled(expressions, node)
    repeats = expressions.repeated(count, node.span)
    scope, python = Scope(expressions.scope), expressions.unit.name("q")
    scope.symbols[node.variable] = Local(node.variable, Type("int", low, high), python, written=False)
    body = expressions.inside(scope, repeats=repeats).value(node.body)
    loop = f"for {python} in range({low}, {high + 1})"
    if node.kind == "sum":
        body = body.integer
        return Value(f"sum({body.source} {loop})", count * body.low, count * body.high)
    word = "all" if node.kind == "forall" else "any"
    return Value(f"{word}({body.source} {loop})", 0, 1, truth=True)


def unrolled(expressions: Expressions, node: ast.Quantified) -> Value:
    """The same, written out for each value."""
    low, high = expressions.bounds(node.type)
    repeats = expressions.repeated(high - low + 1, node.span)
    bodies = [
        expressions.binding(node.variable, value, repeats=repeats).value(node.body)
        for value in range(low, high + 1)
    ]
    if node.kind == "sum":
        return _sum([body.integer for body in bodies])
    decisive = node.kind == "exists"
    parts = []
    for body in bodies:
        if body.known is None:
            parts.append(body.source)
        elif bool(body.known) == decisive:
            return Value.of(int(decisive))
    if not parts:
        return Value.of(int(not decisive))
    return Value("(" + (" or " if decisive else " and ").join(parts) + ")", 0, 1, truth=True)


def _sum(bodies: list[Value]) -> Value:
    low, high = sum(body.low for body in bodies), sum(body.high for body in bodies)
    if all(body.known is not None for body in bodies):
        return Value.of(low)
    return Value("(" + " + ".join(body.source for body in bodies) + ")", low, high)
