"""From lark's parse tree to the syntax tree; what the grammar reads only to refuse it is refused here."""

from __future__ import annotations

from typing import Any

from lark import Token, Transformer, v_args

from timed_automata._limits import DIGITS
from timed_automata.document import Span, Text, fault, refused
from timed_automata.language import ast

_WORDS = {"and": "&&", "or": "||", "not": "!"}


@v_args(meta=True)
class Builder(Transformer[Token, Any]):
    """One method per rule of the grammar; children come as nodes, tokens or None."""

    def __init__(self, text: Text) -> None:
        super().__init__()
        self._text = text

    def _name(self, meta: Any, token: Any) -> str:
        """A name that is declared; ``deadlock`` would mean something else in every query."""
        if token == "deadlock":
            what = "'deadlock' is reserved: queries ask for it."
            raise fault(self._span(meta), what, "Choose another name.")
        return str(token)

    def _span(self, meta: Any) -> Span:
        if meta.empty:
            return self._text.whole
        return Span(self._text, meta.start_pos, meta.end_pos)

    # Expressions

    def number(self, meta: Any, children: list[Any]) -> ast.Number:
        span = self._span(meta)
        if len(children[0]) > DIGITS:
            raise fault(span, f"A number of {len(children[0])} digits.", f"Expected at most {DIGITS} digits.")
        return ast.Number(span, int(children[0]))

    def boolean(self, meta: Any, children: list[Any]) -> ast.Number:
        return ast.Number(self._span(meta), int(children[0] == "true"), boolean=True)

    def double(self, meta: Any, children: list[Any]) -> ast.Number:
        raise refused(self._span(meta), f"'{children[0]}', a floating-point number", "Use integers.")

    def name(self, meta: Any, children: list[Any]) -> ast.Name:
        return ast.Name(self._span(meta), str(children[0]))

    def index(self, meta: Any, children: list[Any]) -> ast.Index:
        return ast.Index(self._span(meta), *children)

    def member(self, meta: Any, children: list[Any]) -> ast.Member:
        return ast.Member(self._span(meta), children[0], str(children[1]))

    def rate(self, meta: Any, children: list[Any]) -> None:
        span = self._span(meta)
        raise refused(span, f"'{span.snippet}', the rate of a clock (stopwatch)", "Clocks run at rate one.")

    def call(self, meta: Any, children: list[Any]) -> ast.Call:
        return ast.Call(self._span(meta), str(children[0]), children[1])

    def unary(self, meta: Any, children: list[Any]) -> ast.Unary:
        op = str(children[0])
        return ast.Unary(self._span(meta), _WORDS.get(op, op), children[1])

    def binary(self, meta: Any, children: list[Any]) -> ast.Binary:
        left, op, right = children
        return ast.Binary(self._span(meta), _WORDS.get(str(op), str(op)), left, right)

    def conditional(self, meta: Any, children: list[Any]) -> ast.Conditional:
        test, _, yes, no = children
        return ast.Conditional(self._span(meta), test, yes, no)

    def quantified(self, meta: Any, children: list[Any]) -> ast.Quantified:
        kind, variable, type_, body = children
        return ast.Quantified(self._span(meta), str(kind), self._name(meta, variable), type_, body)

    def assignment(self, meta: Any, children: list[Any]) -> ast.Assignment:
        target, op, value = children
        return ast.Assignment(self._span(meta), "=" if op == ":=" else str(op), target, value)

    def step(self, meta: Any, children: list[Any]) -> ast.Increment:
        op, target = sorted(children, key=lambda child: not isinstance(child, Token))
        return ast.Increment(self._span(meta), str(op), target)

    def braces(self, meta: Any, children: list[Any]) -> ast.Braces:
        return ast.Braces(self._span(meta), tuple(children))

    def items(self, meta: Any, children: list[Any]) -> tuple[Any, ...]:
        return tuple(child for child in children if child is not None)

    parameters = declarations = instantiations = selects = items

    # Declarations

    def integer(self, meta: Any, children: list[Any]) -> ast.TypeName:
        low, high = children
        return ast.TypeName(self._span(meta), "int", low=low, high=high)

    def type_name(self, meta: Any, children: list[Any]) -> ast.TypeName:
        *prefixes, base = children
        span, kinds = self._span(meta), frozenset(map(str, prefixes))
        if isinstance(base, ast.TypeName):
            return ast.TypeName(span, "int", kinds, base.low, base.high)
        return ast.TypeName(span, str(base), kinds)

    def declarator(self, meta: Any, children: list[Any]) -> ast.Declarator:
        name, *dimensions, _, initialiser = children
        return ast.Declarator(self._span(meta), self._name(meta, name), tuple(dimensions), initialiser)

    def variables(self, meta: Any, children: list[Any]) -> ast.Variables:
        return ast.Variables(self._span(meta), children[0], tuple(children[1:]))

    def typedef(self, meta: Any, children: list[Any]) -> ast.TypeDefinition:
        return ast.TypeDefinition(self._span(meta), children[0], tuple(children[1:]))

    def parameter(self, meta: Any, children: list[Any]) -> ast.Parameter:
        type_, reference, name, *dimensions = children
        span = self._span(meta)
        return ast.Parameter(
            span,
            type_,
            reference is not None,
            ast.Declarator(span, self._name(meta, name), tuple(dimensions)),
        )

    def function(self, meta: Any, children: list[Any]) -> ast.FunctionDefinition:
        result, name, parameters, body = children
        return ast.FunctionDefinition(self._span(meta), result, self._name(meta, name), parameters, body)

    def instantiation(self, meta: Any, children: list[Any]) -> ast.Instantiation:
        name, parameters, _, template, arguments = children
        return ast.Instantiation(self._span(meta), str(name), parameters or (), template, arguments)

    def priority(self, meta: Any, children: list[Any]) -> None:
        raise refused(self._span(meta), "'<' between processes, a priority", "Separate processes with ','.")

    def system(self, meta: Any, children: list[Any]) -> ast.System:
        items = tuple(child for child in children if not isinstance(child, ast.Name))
        return ast.System(self._span(meta), items, tuple(c for c in children if isinstance(c, ast.Name)))

    def select(self, meta: Any, children: list[Any]) -> ast.Select:
        return ast.Select(self._span(meta), self._name(meta, children[0]), children[1])

    def synchronisation(self, meta: Any, children: list[Any]) -> ast.Synchronisation:
        channel, direction = children
        if direction == "not":
            raise fault(self._span(meta), "'not' after a channel.", "Expected '!' or '?'.")
        return ast.Synchronisation(self._span(meta), channel, str(direction))

    # Statements

    def block(self, meta: Any, children: list[Any]) -> ast.Block:
        declared = (ast.Variables, ast.TypeDefinition)
        return ast.Block(
            self._span(meta),
            tuple(child for child in children if isinstance(child, declared)),
            tuple(child for child in children if not isinstance(child, declared)),
        )

    def evaluate(self, meta: Any, children: list[Any]) -> ast.Evaluate:
        return ast.Evaluate(self._span(meta), children[0])

    def if_(self, meta: Any, children: list[Any]) -> ast.If:
        return ast.If(self._span(meta), *children)

    def for_(self, meta: Any, children: list[Any]) -> ast.For:
        return ast.For(self._span(meta), *children)

    def while_(self, meta: Any, children: list[Any]) -> ast.For:
        test, body = children
        return ast.For(self._span(meta), (), test, (), body)

    def do(self, meta: Any, children: list[Any]) -> ast.DoWhile:
        return ast.DoWhile(self._span(meta), *children)

    def iterate(self, meta: Any, children: list[Any]) -> ast.Iterate:
        variable, type_, body = children
        return ast.Iterate(self._span(meta), str(variable), type_, body)

    def return_(self, meta: Any, children: list[Any]) -> ast.Return:
        return ast.Return(self._span(meta), children[0])
