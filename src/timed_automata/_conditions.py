"""Compiling guards and invariants: the conjunction is split into data and clock constraints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

from timed_automata import _ast as ast
from timed_automata._constraints import ClockConstraint, Condition, Quantity, Relation
from timed_automata._expressions import Expressions
from timed_automata._faults import fault, refused
from timed_automata._scope import Clock
from timed_automata._values import Indexed

_RELATIONS: dict[str, Relation] = {"<": "<", "<=": "<=", "==": "==", ">=": ">=", ">": ">"}
_FLIPPED: dict[str, Relation] = {"<": ">", "<=": ">=", "==": "==", ">=": "<=", ">": "<"}

Part = tuple[Expressions, ast.Expression]


def mentions_clock(expressions: Expressions, node: object) -> bool:
    """Whether a clock occurs anywhere in an expression."""
    if isinstance(node, ast.Name):
        return isinstance(expressions.scope.find(node.name), Clock)
    if isinstance(node, tuple):
        return any(mentions_clock(expressions, item) for item in node)
    if isinstance(node, ast.Node):
        return any(mentions_clock(expressions, getattr(node, name)) for name in node.__dataclass_fields__)
    return False


def _parts(expressions: Expressions, node: ast.Expression) -> Iterator[Part]:
    """The parts of a conjunction, each with its scope; forall over clocks is written out."""
    if isinstance(node, ast.Binary) and node.op == "&&":
        yield from _parts(expressions, node.left)
        yield from _parts(expressions, node.right)
    elif isinstance(node, ast.Quantified) and node.kind == "forall" and mentions_clock(expressions, node):
        low, high = expressions.bounds(node.type)
        for value in range(low, high + 1):
            yield from _parts(expressions.binding(node.variable, value), node.body)
    else:
        yield expressions, node


def _refuse(expressions: Expressions, node: ast.Expression) -> NoReturn:
    """Say what is wrong with a clock in this place."""
    todo = "Expected a conjunction of 'clock <= number' and conditions without clocks."
    match node:
        case ast.Binary(op="||" | "imply"):
            construct = "a disjunction over clocks"
        case ast.Binary(op="!="):
            construct = "'!=' on a clock"
        case ast.Binary(op="<" | "<=" | "==" | ">=" | ">", left=left, right=right):
            both = mentions_clock(expressions, left) and mentions_clock(expressions, right)
            difference = any(isinstance(side, ast.Binary) and side.op == "-" for side in (left, right))
            construct = "a diagonal constraint" if both or difference else "arithmetic with a clock"
            todo = "Compare each clock with a number." if both or difference else todo
        case ast.Conditional():
            construct = "a clock in '?:'"
        case ast.Unary(op="!"):
            construct = "the negation of a clock constraint"
        case ast.Quantified():
            construct = f"'{node.kind}' over clock constraints"
        case _:
            construct = "a clock in an expression over data"
    raise refused(node.span, f"'{node.span.snippet}', {construct}", todo)


def _clock(expressions: Expressions, node: ast.Expression) -> Indexed | None:
    if not isinstance(node, ast.Name | ast.Index):
        return None
    base: ast.Expression = node
    while isinstance(base, ast.Index):
        base = base.base
    if not isinstance(base, ast.Name) or not isinstance(expressions.scope.find(base.name), Clock):
        return None
    term = expressions.term(node)
    if not isinstance(term, Indexed) or term.type.dimensions:
        raise fault(node.span, f"'{node.span.snippet}' is an array of clocks.", "Expected an index.")
    return term


def _constraint(expressions: Expressions, node: ast.Expression) -> ClockConstraint:
    if not isinstance(node, ast.Binary) or node.op not in _RELATIONS:
        _refuse(expressions, node)
    term, op, bound = _clock(expressions, node.left), _RELATIONS[node.op], node.right
    if term is None:
        term, op, bound = _clock(expressions, node.right), _FLIPPED[node.op], node.left
    if term is None or mentions_clock(expressions, bound):
        _refuse(expressions, node)
    expressions.effects.reads.add(term.name)
    value = expressions.integer(bound)
    return ClockConstraint(
        clock=number_of(expressions, term),
        op=op,
        bound=value.known if value.known is not None else _function(expressions, value.source),
        clocks=term.possible,
        low=value.low,
        high=value.high,
        span=node.span,
    )


def number_of(expressions: Expressions, term: Indexed) -> Quantity:
    """The number of a clock or a channel."""
    return _function(expressions, term.source) if term.computed else term.possible.start


def _function(expressions: Expressions, source: str) -> Quantity:
    return expressions.unit.expression("v, r=None", source)


def compile_condition(expressions: Expressions, node: ast.Expression, what: str) -> Condition:
    """A guard or an invariant.

    Raises:
        ModelError: it has an effect, or clocks stand in it in a way that is outside of the subset.
    """
    clocks: list[ClockConstraint] = []
    data: list[str] = []
    never = False
    for inner, part in _parts(expressions, node):
        if mentions_clock(inner, part):
            clocks.append(_constraint(inner, part))
            continue
        value = inner.value(part)
        if value.known is None:
            data.append(value.source)
        never = never or value.known == 0
    if expressions.effects.writes:
        changed = ", ".join(sorted(expressions.effects.writes))
        raise fault(node.span, f"The {what} '{node.span.snippet}' changes {changed}.")
    function = expressions.unit.expression("v, r=None", " and ".join(data)) if data else None
    return Condition(function, never, tuple(clocks))
