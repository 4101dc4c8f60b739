"""Single edits of a text: its comparisons, numbers, connectives, assignments and statements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from timed_automata.document import Span, Text
from timed_automata.language import ast

_COMPARISONS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
}
"""The replacements of a comparison: its neighbour at the bound, and its opposite."""
Functions = Mapping[str, ast.FunctionDefinition]
_CONNECTIVES = {"&&": "||", "||": "&&"}


class TextEdit(NamedTuple):
    """The replacement of a part of a text."""

    operator: str
    span: Span
    new: str

    def applied(self) -> Text:
        """Return the whole text with the edit."""
        content = self.span.text.content
        edited = content[: self.span.start] + self.new + content[self.span.end :]
        return Text.plain(edited, f"{self.span.where}, edited")


def in_expression(node: ast.Node) -> Iterator[TextEdit]:
    """Yield the edits of an expression, or of all expressions in a statement."""
    for each in ast.walk(node):
        match each:
            case ast.Binary(left=left, op=op, right=right) if op in _COMPARISONS:
                yield from (_operator(each, other) for other in _COMPARISONS[op])
                yield from _one_off(right)
            case ast.Binary(left=left, op=op, right=right) if op in _CONNECTIVES:
                yield _operator(each, _CONNECTIVES[op])
                yield TextEdit("condition dropped", each.span, _source(right))
                yield TextEdit("condition dropped", each.span, _source(left))
            case ast.Binary(left=left, op="imply", right=right):
                yield TextEdit("condition dropped", each.span, _source(right))
            case ast.Binary(right=right):
                yield from _one_off(right)
            case ast.Unary(op="!", operand=operand):
                yield TextEdit("negation", each.span, f"({_source(operand)})")
            case ast.Conditional(yes=yes, no=no):
                yield TextEdit("condition dropped", each.span, f"({_source(yes)})")
                yield TextEdit("condition dropped", each.span, f"({_source(no)})")
                yield from (*_one_off(yes), *_one_off(no))
            case ast.Quantified(kind="forall" | "exists" as kind):
                other = "exists" if kind == "forall" else "forall"
                start = each.span.start
                yield TextEdit("quantifier", Span(each.span.text, start, start + len(kind)), other)
            case ast.Assignment(value=value):
                yield from _one_off(value)
            case ast.Call(arguments=arguments):
                yield from (edit for argument in arguments for edit in _one_off(argument))
            case ast.Index(index=index):
                yield from _one_off(index)
            case ast.Return(value=value) if value is not None:
                yield from _one_off(value)
            case ast.Number(value=value, boolean=True):
                yield TextEdit("constant", each.span, "false" if value else "true")
            case ast.Increment(op=op):
                start, end = each.span.start, each.span.end
                at = start if each.before else end - 2
                yield TextEdit("constant", Span(each.span.text, at, at + 2), "--" if op == "++" else "++")


def in_guard(node: ast.Expression) -> Iterator[TextEdit]:
    """Yield the edits of a guard or an invariant, among them its removal and its negation."""
    yield TextEdit("condition dropped", node.span.text.whole, "true")
    if isinstance(node, ast.Name | ast.Index | ast.Call):
        yield TextEdit("negation", node.span, f"!{_source(node)}")
    for each in ast.walk(node):
        if isinstance(each, ast.Binary) and each.op in _CONNECTIVES:
            for side in (each.left, each.right):
                if isinstance(side, ast.Name | ast.Index | ast.Call):
                    yield TextEdit("negation", side.span, f"!{_source(side)}")
    yield from in_expression(node)


def in_updates(nodes: Sequence[ast.Expression], functions: Functions) -> Iterator[TextEdit]:
    """Yield the edits of an assignment label; `functions` are those that it may call, by name."""
    for number, node in enumerate(nodes):
        others = [_source(other) for other in nodes if other is not node]
        yield TextEdit("assignment dropped", node.span.text.whole, ", ".join(others))
        if number and not _commute(nodes[number - 1], node, functions):
            swapped = [_source(other) for other in nodes]
            swapped[number - 1 : number + 1] = swapped[number], swapped[number - 1]
            yield TextEdit("assignments swapped", node.span.text.whole, ", ".join(swapped))
        yield from in_expression(node)


def in_function(function: ast.FunctionDefinition) -> Iterator[TextEdit]:
    """Yield the edits of a function's body."""
    yield from _in_statement(function.body)


def in_declarator(declarator: ast.Declarator, *, boolean: bool) -> Iterator[TextEdit]:
    """Yield the edits of the initial value of a constant or a variable; arrays are not edited."""
    if declarator.dimensions:
        return
    if (begins := declarator.initialiser) is None:
        end = declarator.span.end
        yield TextEdit("constant", Span(declarator.span.text, end, end), " = true" if boolean else " = 1")
    elif isinstance(begins, ast.Expression):
        yield from _one_off(begins)
        yield from in_expression(begins)


def _in_statement(node: ast.Statement) -> Iterator[TextEdit]:
    match node:
        case ast.Block(statements=statements):
            for statement in statements:
                yield from _in_statement(statement)
        case ast.If(test=test, yes=yes, no=no):
            yield TextEdit("assignment dropped", node.span, _source(no) if no else ";")
            yield TextEdit("condition dropped", test.span, "true")
            yield from in_guard_part(test)
            yield from _in_statement(yes)
            if no is not None:
                yield from _in_statement(no)
        case ast.Evaluate(expression=expression) if expression is not None:
            yield TextEdit("assignment dropped", node.span, ";")
            yield from in_expression(expression)
        case ast.Iterate(body=body):
            yield from _in_statement(body)
        case ast.For(test=test, body=body):
            if test is not None:
                yield from in_expression(test)
            yield from _in_statement(body)
        case ast.Return(value=value) if value is not None:
            yield from in_expression(node)


def in_guard_part(test: ast.Expression) -> Iterator[TextEdit]:
    """Yield the edits of a condition that is a part of a text."""
    if isinstance(test, ast.Name | ast.Index | ast.Call):
        yield TextEdit("negation", test.span, f"!{_source(test)}")
    yield from in_expression(test)


def _commute(one: ast.Expression, other: ast.Expression, functions: Functions) -> bool:
    """Return whether the order of two assignments is irrelevant."""
    (one_reads, one_writes), (other_reads, other_writes) = (
        _effects(one, functions),
        _effects(other, functions),
    )
    return one_writes.isdisjoint(other_reads | other_writes) and other_writes.isdisjoint(one_reads)


def _effects(node: ast.Node, functions: Functions) -> tuple[set[str], set[str]]:
    """Return the names in a text, and the names that it changes, including its calls."""
    reads, writes = set[str](), ast.changed(node)
    for each in ast.walk(node):
        if isinstance(each, ast.Name):
            reads.add(each.name)
        elif isinstance(each, ast.Call) and each.name in functions:
            inner = _effects(functions[each.name].body, functions)
            reads |= inner[0]
            writes |= inner[1]
    return reads, writes


def _source(node: ast.Node) -> str:
    return node.span.text.content[node.span.start : node.span.end]


def _operator(node: ast.Binary, new: str) -> TextEdit:
    """Replace an operator; only the operator, brackets and blanks are between its operands."""
    content, start, end = node.span.text.content, node.left.span.end, node.right.span.start
    between = content[start:end]
    words = {"&&": ("&&", "and"), "||": ("||", "or")}.get(node.op, (node.op,))
    word = next(word for word in words if word in between)
    at = start + between.index(word)
    kind = "comparison" if node.op in _COMPARISONS else "connective"
    return TextEdit(kind, Span(node.span.text, at, at + len(word)), new)


def _one_off(value: ast.Expression) -> Iterator[TextEdit]:
    """Yield a value one higher, and one lower."""
    if isinstance(value, ast.Number):
        if not value.boolean:
            yield TextEdit("constant", value.span, str(value.value + 1))
            yield TextEdit("constant", value.span, str(value.value - 1))
    elif isinstance(value, ast.Name | ast.Index | ast.Call) or (
        isinstance(value, ast.Binary) and value.op in ("+", "-", "*")
    ):
        yield TextEdit("constant", value.span, f"({_source(value)} + 1)")
        yield TextEdit("constant", value.span, f"({_source(value)} - 1)")
