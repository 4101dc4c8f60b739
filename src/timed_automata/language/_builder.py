"""Converts lark's parse tree to the syntax tree, and refuses constructs that the grammar accepts only to
report them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from lark import Token, Tree

from timed_automata._limits import DIGITS, NESTING
from timed_automata.document import Span, Text, fault, refused
from timed_automata.language import ast

_WORDS = {"and": "&&", "or": "||", ":=": "="}
_LEVELS = {
    "OR": 0,
    "AND": 1,
    "BIT_OR": 2,
    "BIT_XOR": 3,
    "AMPERSAND": 4,
    "EQUALITY": 5,
    "COMPARISON": 6,
    "EXTREME": 7,
    "SHIFT": 8,
    "SIGN": 9,
    "FACTOR": 10,
}
"""Precedence of operators; a higher number binds more closely."""
_NODES: dict[str, type[ast.Node]] = {
    "name": ast.Name,
    "index": ast.Index,
    "member": ast.Member,
    "call": ast.Call,
    "assignment": ast.Assignment,
    "evaluate": ast.Evaluate,
    "if_": ast.If,
    "for_": ast.For,
    "do": ast.DoWhile,
    "iterate": ast.Iterate,
    "return_": ast.Return,
}
"""Grammar rules whose children are the fields of the node, in this order."""


class _Operand(NamedTuple):
    """An operand of an operator; ``start`` and ``end`` include the brackets around the node."""

    start: int
    end: int
    node: Any


class Builder:
    """Builds nodes, with one method for every grammar rule not in ``_NODES``; children are nodes, words or None."""

    def __init__(self, text: Text) -> None:
        self._text = text

    def build(self, tree: Tree[Token]) -> Any:
        """Return the node for a parse tree."""
        rule = tree.data
        if rule == "operation":
            return self._operation(tree.children)
        children = [
            self.build(child) if isinstance(child, Tree) else child and _WORDS.get(child, str(child))
            for child in tree.children
        ]
        if node := _NODES.get(rule):
            return node(self._span(tree.meta), *children)
        return getattr(self, rule)(tree.meta, *children)

    def _operation(self, children: list[Any]) -> Any:
        """Build the tree of operands and operators, from left to right, by the precedence of the operators."""
        if len(children) > 2 * NESTING:  # each operator is one level of what is built
            raise fault(self._text.whole, "This text is nested too deeply.", "Break it into parts.")
        operators: list[Token] = []
        operands = [self._operand(children[0])]
        for operator, operand in zip(children[1::2], children[2::2], strict=True):
            while operators and _LEVELS[operators[-1].type] >= _LEVELS[operator.type]:
                self._join(operands, operators.pop())
            operators.append(operator)
            operands.append(self._operand(operand))
        while operators:
            self._join(operands, operators.pop())
        return operands[0].node

    def _operand(self, tree: Tree[Token]) -> _Operand:
        # lark says where a tree stands with its brackets in attributes that only such a tree may have
        start = getattr(tree.meta, "container_start_pos", tree.meta.start_pos)
        return _Operand(start, getattr(tree.meta, "container_end_pos", tree.meta.end_pos), self.build(tree))

    def _join(self, operands: list[_Operand], operator: Token) -> None:
        right, left = operands.pop(), operands.pop()
        span = Span(self._text, left.start, right.end)
        node = ast.Binary(span, left.node, _WORDS.get(operator, str(operator)), right.node)
        operands.append(_Operand(left.start, right.end, node))

    def _span(self, meta: Any) -> Span:
        return self._text.whole if meta.empty else Span(self._text, meta.start_pos, meta.end_pos)

    def _declared(self, meta: Any, name: str) -> tuple[Span, str]:
        """Return the place of a declared name, and the name; refuse ``deadlock``, which has another meaning in
        queries.
        """
        span = self._span(meta)
        if name == "deadlock":
            raise fault(span, "'deadlock' is reserved for queries.", "Choose another name.")
        return span, name

    # Expressions

    def number(self, meta: Any, digits: str) -> ast.Number:
        span = self._span(meta)
        if len(digits) > DIGITS:
            raise fault(span, f"A number of {len(digits)} digits.", f"Expected at most {DIGITS} digits.")
        return ast.Number(span, int(digits))

    def boolean(self, meta: Any, word: str) -> ast.Number:
        return ast.Number(self._span(meta), int(word == "true"), boolean=True)

    def double(self, meta: Any, digits: str) -> None:
        raise refused(
            self._span(meta), f"'{digits}', a floating-point number", "Use an integer of a smaller unit."
        )

    def rate(self, meta: Any, _clock: Any, _apostrophe: str) -> None:
        span = self._span(meta)
        todo = "Clocks run at rate one: count the time in steps of an automaton."
        raise refused(span, f"'{span.snippet}', the rate of a clock (stopwatch)", todo)

    def method(self, meta: Any, process: Any, name: str, arguments: Any) -> ast.Call:
        return ast.Call(self._span(meta), name, arguments, process)

    def unary(self, meta: Any, op: str, operand: Any) -> ast.Unary:
        return ast.Unary(self._span(meta), "!" if op == "not" else op, operand)

    def conditional(self, meta: Any, test: Any, _: str, yes: Any, no: Any) -> ast.Conditional:
        return ast.Conditional(self._span(meta), test, yes, no)

    def quantified(self, meta: Any, kind: str, variable: str, type_: Any, body: Any) -> ast.Quantified:
        span, name = self._declared(meta, variable)
        return ast.Quantified(span, kind, name, type_, body)

    def step(self, meta: Any, *children: Any) -> ast.Increment:
        before = isinstance(children[0], str)
        op, target = children if before else reversed(children)
        return ast.Increment(self._span(meta), op, target, before)

    def braces(self, meta: Any, *children: Any) -> ast.Braces:
        names, items = zip(*children, strict=True)
        return ast.Braces(self._span(meta), items, names)

    def item(self, _meta: Any, name: str | None, value: Any) -> tuple[str | None, Any]:
        return name, value

    def items(self, _meta: Any, *children: Any) -> tuple[Any, ...]:
        return tuple(child for child in children if child is not None)

    parameters = declarations = instantiations = selects = items

    # Declarations

    def integer(self, meta: Any, low: Any, high: Any) -> ast.TypeName:
        return ast.TypeName(self._span(meta), "int", low=low, high=high)

    def scalar(self, meta: Any, size: Any) -> ast.TypeName:
        return ast.TypeName(self._span(meta), "scalar", high=size)

    def structure(self, meta: Any, *fields: Any) -> ast.TypeName:
        return ast.TypeName(self._span(meta), "struct", fields=fields)

    def plain(self, meta: Any, name: str, *dimensions: Any) -> ast.Declarator:
        return ast.Declarator(*self._declared(meta, name), dimensions)

    def type_name(self, meta: Any, *children: Any) -> ast.TypeName:
        *prefixes, base = children
        span, kinds = self._span(meta), frozenset(prefixes)
        if isinstance(base, ast.TypeName):
            return ast.TypeName(span, base.base, kinds, base.low, base.high, base.fields)
        return ast.TypeName(span, base, kinds)

    def declarator(self, meta: Any, name: str, *children: Any) -> ast.Declarator:
        *dimensions, _, initialiser = children
        return ast.Declarator(*self._declared(meta, name), tuple(dimensions), initialiser)

    def variables(self, meta: Any, type_: Any, *declarators: Any) -> ast.Variables:
        return ast.Variables(self._span(meta), type_, declarators)

    field = variables

    def typedef(self, meta: Any, type_: Any, *declarators: Any) -> ast.TypeDefinition:
        return ast.TypeDefinition(self._span(meta), type_, declarators)

    def parameter(self, meta: Any, type_: Any, reference: Any, name: str, *dimensions: Any) -> ast.Parameter:
        declarator = ast.Declarator(*self._declared(meta, name), dimensions)
        return ast.Parameter(declarator.span, type_, reference is not None, declarator)

    def function(
        self, meta: Any, result: Any, name: str, parameters: Any, body: Any
    ) -> ast.FunctionDefinition:
        span, name = self._declared(meta, name)
        return ast.FunctionDefinition(span, result, name, parameters, body)

    def instantiation(
        self, meta: Any, name: str, parameters: Any, _: str, template: Any, arguments: Any
    ) -> ast.Instantiation:
        return ast.Instantiation(self._span(meta), name, parameters or (), template, arguments)

    def priority(self, meta: Any, _: str) -> None:
        raise refused(self._span(meta), "'<' between processes, a priority", "Separate processes with ','.")

    def system(self, meta: Any, *children: Any) -> ast.System:
        items = tuple(child for child in children if not isinstance(child, ast.Name))
        return ast.System(self._span(meta), items, tuple(c for c in children if isinstance(c, ast.Name)))

    def select(self, meta: Any, name: str, type_: Any) -> ast.Select:
        return ast.Select(*self._declared(meta, name), type_)

    def synchronisation(self, meta: Any, channel: Any, direction: str) -> ast.Synchronisation:
        if direction == "not":
            raise fault(self._span(meta), "'not' after a channel.", "Expected '!' or '?'.")
        return ast.Synchronisation(self._span(meta), channel, direction)

    # Statements

    def block(self, meta: Any, *children: Any) -> ast.Block:
        declared = (ast.Variables, ast.TypeDefinition)
        return ast.Block(
            self._span(meta),
            tuple(child for child in children if isinstance(child, declared)),
            tuple(child for child in children if not isinstance(child, declared)),
        )

    def while_(self, meta: Any, test: Any, body: Any) -> ast.For:
        return ast.For(self._span(meta), (), test, (), body)
