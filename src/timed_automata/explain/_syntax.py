"""Writes conditions as text and splits them into parts; expands quantifiers and functions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, cast

from timed_automata.language import ast

_BINDS = {"imply": 2, "||": 2, "&&": 3, "==": 5, "!=": 5, "<": 6, "<=": 6, ">": 6, ">=": 6}
_TIGHT = 7


def instance(node: ast.Quantified, value: int) -> ast.Expression:
    """Return the body of a quantifier for one number; not as a literal, which would be checked even where it is not
    used.
    """
    number = ast.Unary(node.span, "+", ast.Number(node.span, value))
    return cast(ast.Expression, _put(node.body, node.variable, number))


def _put(node: object, name: str, value: ast.Expression) -> Any:
    if isinstance(node, tuple):
        return tuple(_put(each, name, value) for each in node)
    if isinstance(node, ast.Name) and node.name == name:
        return value
    if not isinstance(node, ast.Node) or (isinstance(node, ast.Quantified) and node.variable == name):
        return node
    changes = {at: _put(getattr(node, at), name, value) for at in node.__dataclass_fields__ if at != "span"}
    return replace(node, **changes)


def number_of(node: ast.Expression) -> int | None:
    """Return the number of a literal, or of a number that `instance` put in; None for other expressions."""
    if isinstance(node, ast.Unary) and node.op in "+-" and (inner := number_of(node.operand)) is not None:
        return -inner if node.op == "-" else inner
    return node.value if isinstance(node, ast.Number) else None


def returned(function: ast.FunctionDefinition | None) -> ast.Expression | None:
    """Return the expression that a function returns, if it has no parameters and only a return; else None."""
    match function:
        case ast.FunctionDefinition(
            parameters=(), body=ast.Block(declarations=(), statements=(ast.Return(value=value),))
        ):
            return value
    return None


Atom = Callable[[ast.Expression], str | None]
"""Returns the special text of an expression, or None if it has none."""


def written(node: ast.Expression, atom: Atom, binds: int = 0) -> str:
    """Return an expression as text; ``atom`` gives the words for names and elements."""
    if (own := atom(node)) is not None:
        return own
    match node:
        case ast.Unary(op="+"):
            return written(node.operand, atom, binds)
        case ast.Unary(op=op, operand=operand):
            return f"{op}{written(operand, atom, _TIGHT)}"
        case ast.Binary(left=left, op=op, right=right):
            own_binds = _BINDS.get(op, _TIGHT - 1)
            tighter = own_binds + (op not in ("&&", "||"))
            text = f"{written(left, atom, tighter)} {op} {written(right, atom, tighter)}"
            return f"({text})" if own_binds < binds else text
        case ast.Conditional(test=test, yes=yes, no=no):
            return f"({written(test, atom, 1)} ? {written(yes, atom, 1)} : {written(no, atom, 1)})"
        case ast.Quantified(kind=kind, variable=variable, type=type_, body=body):
            text = f"{kind} ({variable} : {type_.span.snippet}) {written(body, atom)}"
            return f"({text})" if binds else text
    return node.span.snippet


def parts_of(node: ast.Expression, op: str) -> Iterator[ast.Expression]:
    """Yield the operands of a chain of one operator."""
    if isinstance(node, ast.Binary) and node.op == op:
        yield from parts_of(node.left, op)
        yield from parts_of(node.right, op)
    else:
        yield node
