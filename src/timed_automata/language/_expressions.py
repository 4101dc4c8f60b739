"""Reads expressions by recursive descent; operators are joined by their precedence."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, TypeVar

from timed_automata._limits import DIGITS, NESTING
from timed_automata.document import Span, Text, fault, refused
from timed_automata.errors import ModelError
from timed_automata.language import ast
from timed_automata.language._tokens import DOUBLE, END, FOREIGN, NAME, NUMBER, REFUSED, REFUSED_WORDS, tokens

_Item = TypeVar("_Item")
_SWITCH = re.compile(r"\bswitch\s*\([^{}]*\)\s*\Z")
_SIGNS = frozenset(("-", "+", "!"))
_STEPS = frozenset(("++", "--"))
_QUANTIFIERS = frozenset(("forall", "exists", "sum"))
_ASSIGN = frozenset(("=", "<<=", ">>=", "-=", "+=", "*=", "/=", "%=", "&=", "|=", "^="))
_PRIMARY = frozenset((NAME, NUMBER, DOUBLE, "true", "false"))
OPERAND = _SIGNS | _STEPS | _QUANTIFIERS | _PRIMARY | {"("}
"""Kinds of tokens with which an expression begins."""
_PRECEDENCE = "|| imply, &&, |, ^, &, == !=, < <= > >=, <? >?, << >>, + -, * / %"
_LEVELS = {word: level for level, words in enumerate(_PRECEDENCE.split(",")) for word in words.split()}
"""Precedence of operators, as in UPPAAL; a higher number binds more closely."""
_EXPRESSION, _OPERATOR = "an expression", "an operator"


def too_deep(text: Text) -> ModelError:
    """Return the error for a text whose nesting has no limit that can be named."""
    return fault(text.whole, "This text is nested too deeply.", "Break it into parts.")


class ExpressionParser(ABC):
    """A position in the tokens of a text, and what could stand there."""

    def __init__(self, text: Text) -> None:
        self._text = text
        self._tokens = tokens(text.content)
        self._index = 0
        self._token = self._tokens[0]
        self._end = 0
        self._wanted: set[str] = set()

    # Tokens

    def _next(self) -> str:
        """Return the word of this token, and go on to the next one."""
        token = self._token
        self._index += 1
        self._token, self._end = self._tokens[self._index], token.end
        self._wanted.clear()
        return token.word

    def _at(self, kind: str) -> bool:
        """Return whether this token is of a kind; remember what would have been."""
        if self._token.kind == kind:
            return True
        self._wanted.add(kind)
        return False

    def _skip(self, kind: str) -> bool:
        """Go on if this token is of a kind, and return whether it is."""
        found = self._at(kind)
        if found:
            self._next()
        return found

    def _take(self, kind: str) -> str:
        """Return the word of this token, which must be of a kind, and go on."""
        if self._token.kind != kind:
            raise self._unexpected(kind)
        return self._next()

    def _followed_by(self, *kinds: str) -> bool:
        """Return whether this is a name, and the next token is of one of these kinds."""
        return self._token.kind == NAME and self._tokens[self._index + 1].kind in kinds

    def _span(self, start: int) -> Span:
        return Span(self._text, start, self._end)

    def _declared(self, start: int, name: str) -> Span:
        """Return the place of a declaration; refuse the name ``deadlock``, which has another meaning in queries."""
        span = self._span(start)
        if name == "deadlock":
            raise fault(span, "'deadlock' is reserved for queries.", "Choose another name.")
        return span

    def _separated(self, read: Callable[[], _Item]) -> tuple[_Item, ...]:
        """Read one item or more with commas between them."""
        found = [read()]
        while self._skip(","):
            found.append(read())
        return tuple(found)

    def _unexpected(self, *wanted: str) -> ModelError:
        """Return the error for this token, which is none of what could stand here."""
        token, text = self._token, self._text
        place = Span(text, token.start, token.end)
        if token.kind == FOREIGN:
            return fault(place, f"'{token.word}' is no part of the language.")
        if token.kind == REFUSED:
            construct, todo = REFUSED_WORDS[token.word]
            return refused(place, f"'{token.word}', {construct}", todo)
        if token.word == "{" and (found := _SWITCH.search(text.content, 0, token.start)):
            switch = Span(text, found.start(), found.start() + 6)
            return refused(switch, "'switch', this statement", "Use 'if' and 'else'.")
        if text.content.startswith("/*", token.start):
            return fault(place, "This comment does not end.", "Expected '*/'.")
        words = sorted(kind if " " in kind else f"'{kind}'" for kind in self._wanted.union(wanted))
        expected = f"Expected {' or '.join(', '.join(words).rsplit(', ', 1))}."
        if token.kind == END:
            return fault(place, "The text ends too early.", expected)
        return fault(place, f"'{token.word}' is not expected here.", expected)

    # Expressions

    def expression(self) -> Any:
        """Read an expression."""
        start = self._token.start
        return self._expression_from(start, self._unary())

    def _expression_from(self, start: int, first: Any) -> Any:
        """Read the rest of an expression whose first operand has been read."""
        if self._token.kind in _ASSIGN:
            operator = self._token.kind
            self._next()
            value = self.expression()
            return ast.Assignment(self._span(start), first, operator, value)
        self._wanted.add("=")
        return self._conditional(start, first)

    def _conditional(self, start: int, first: Any) -> Any:
        test = self._operation(start, first)
        if self._token.kind != "?":
            return test
        self._next()
        yes = self.expression()
        self._take(":")
        no = self._conditional(self._token.start, self._unary())
        return ast.Conditional(self._span(start), test, yes, no)

    def _operation(self, start: int, first: Any) -> Any:
        """Read operators and operands, and join them by the precedence of the operators, from left to right."""
        operators: list[str] = []
        operands = [(start, self._end, first)]
        read = 0
        while self._token.kind in _LEVELS:
            operator = self._token.kind
            self._next()
            read += 1
            if read >= NESTING:  # each operator is one level of what is built
                raise too_deep(self._text)
            while operators and _LEVELS[operators[-1]] >= _LEVELS[operator]:
                self._join(operands, operators.pop())
            operators.append(operator)
            start = self._token.start
            node = self._unary()
            operands.append((start, self._end, node))
        self._wanted.add(_OPERATOR)
        while operators:
            self._join(operands, operators.pop())
        return operands[0][2]

    def _join(self, operands: list[tuple[int, int, Any]], operator: str) -> None:
        _, end, right = operands.pop()
        start, _, left = operands.pop()
        node = ast.Binary(Span(self._text, start, end), left, operator, right)
        operands.append((start, end, node))

    def _unary(self) -> Any:
        start, kind = self._token.start, self._token.kind
        if kind in _SIGNS:
            self._next()
            operand = self._unary()
            return ast.Unary(self._span(start), kind, operand)
        if kind in _STEPS:
            self._next()
            target = self._unary()
            return ast.Increment(self._span(start), kind, target, True)
        if kind in _QUANTIFIERS:
            self._next()
            variable, type_ = self._in_brackets(self._bound_variable)
            body = self.expression()  # it reaches as far to the right as it can
            return ast.Quantified(self._declared(start, variable), kind, variable, type_, body)
        return self._postfix()

    def _postfix(self) -> Any:
        """Read an operand with what follows it: indices, fields, steps; brackets around it without recursion."""
        start, opened = self._token.start, []
        while self._token.kind == "(":
            opened.append(self._token.start)
            self._next()
        if not opened:
            return self._with_suffixes(start, self._primary())
        node = self.expression()
        while True:
            self._take(")")
            start = opened.pop()
            node = self._with_suffixes(start, node)
            if not opened:
                return node
            node = self._expression_from(start, node)

    def _with_suffixes(self, start: int, node: Any) -> Any:
        while True:
            kind = self._token.kind
            if kind == "[":
                self._next()
                index = self.expression()
                self._take("]")
                node = ast.Index(self._span(start), node, index)
            elif kind == ".":
                self._next()
                name = self._take(NAME)
                if self._token.kind == "(":
                    arguments = self._in_brackets(self.items)
                    node = ast.Call(self._span(start), name, arguments, node)
                else:
                    node = ast.Member(self._span(start), node, name)
            elif kind in _STEPS:
                self._next()
                node = ast.Increment(self._span(start), kind, node, False)
            elif kind == "'":
                self._next()
                span = self._span(start)
                todo = "Clocks run at rate one: count the time in steps of an automaton."
                raise refused(span, f"'{span.snippet}', the rate of a clock (stopwatch)", todo)
            else:
                return node

    def _primary(self) -> Any:
        start, kind = self._token.start, self._token.kind
        if kind not in _PRIMARY:
            raise self._unexpected(_EXPRESSION)
        word = self._next()
        if kind == NAME:
            if self._token.kind != "(":
                return ast.Name(self._span(start), word)
            arguments = self._in_brackets(self.items)
            return ast.Call(self._span(start), word, arguments)
        span = self._span(start)
        if kind == DOUBLE:
            raise refused(span, f"'{word}', a floating-point number", "Use an integer of a smaller unit.")
        if kind != NUMBER:
            return ast.Number(span, int(kind == "true"), boolean=True)
        if len(word) > DIGITS:
            raise fault(span, f"A number of {len(word)} digits.", f"Expected at most {DIGITS} digits.")
        return ast.Number(span, int(word))

    def _in_brackets(self, read: Callable[[], _Item]) -> _Item:
        self._take("(")
        found = read()
        self._take(")")
        return found

    def items(self) -> tuple[Any, ...]:
        """Read any number of expressions."""
        if self._token.kind in OPERAND:
            return self._separated(self.expression)
        self._wanted.add(_EXPRESSION)
        return ()

    @abstractmethod
    def _bound_variable(self) -> tuple[str, ast.TypeName]:
        """Read the name of a variable and its type, with a colon between them."""
