"""Type-checking expressions and compiling them to Python source over the vector of values ``v``."""

from __future__ import annotations

from timed_automata._limits import LONGEST_BITS
from timed_automata.compiler._scope import FormalParameter, Function, Local, Scope
from timed_automata.compiler._term_compiler import TermCompiler
from timed_automata.compiler._terms import StorageTerm
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import (
    COMPARISONS,
    Value,
    arithmetic,
    comparison,
    conditional,
    logical,
    negation,
    signed,
)
from timed_automata.document import fault, refused
from timed_automata.errors import RangeError
from timed_automata.language import ast

_UNROLL = 8  # quantifiers over at most so many values become plain code, which is faster


class Expressions(TermCompiler):
    """Compiles expressions of one scope."""

    def _unary(self, node: ast.Unary) -> Value:
        operand = self.value(node.operand)
        return negation(operand) if node.op == "!" else signed(node.op, operand)

    def _binary(self, node: ast.Binary) -> Value:
        if node.op in ("&&", "||", "imply"):
            return logical(node.op, self.value(node.left), self.value(node.right))
        if node.op in COMPARISONS:
            return self._comparison(node)
        left, right = self.integer(node.left), self.integer(node.right)
        value = arithmetic(node.op, left, right, lambda: self.code.site(node.span, f"'{node.span.snippet}'"))
        if left.known is None or right.known is None:
            return value
        try:
            known: int = self.code.expression("", value.source)()
        except RangeError as error:
            if isinstance(node.right, ast.Number):
                raise fault(node.span, error.what) from None
            return value
        if known.bit_length() > LONGEST_BITS:
            what = f"The result of '{node.span.snippet}' has {known.bit_length()} bits."
            raise fault(node.span, what, "UPPAAL computes with 32.")
        return Value.of(known)

    def _comparison(self, node: ast.Binary) -> Value:
        left, right = self.term(node.left), self.term(node.right)
        if not (isinstance(left, StorageTerm) and isinstance(right, StorageTerm) and left.type.dimensions):
            return comparison(node.op, self.value(node.left), self.value(node.right))
        if left.type.shape != right.type.shape or node.op not in ("==", "!="):
            raise fault(node.span, f"'{left.type}' and '{right.type}' cannot be compared by '{node.op}'.")
        self.read(left.storage)
        self.read(right.storage)
        return Value(f"({left.slice} {node.op} {right.slice})", 0, 1, truth=True)

    def _conditional(self, node: ast.Conditional) -> Value:
        return conditional(self.value(node.test), self.value(node.yes), self.value(node.no))

    def _quantified(self, node: ast.Quantified) -> Value:
        """A quantifier or a sum."""
        low, high = self.bounds(node.type)
        count = high - low + 1
        if count <= _UNROLL:
            return self._unrolled(node)
        repeats = self.repeated(count, node.span)
        scope, python = Scope(self.scope), self.code.name("q")
        scope.symbols[node.variable] = Local(node.variable, Type("int", low, high), python, written=False)
        body = self.inside(scope, repeats=repeats).value(node.body)
        loop = f"for {python} in range({low}, {high + 1})"
        if node.kind == "sum":
            body = body.integer
            return Value(f"sum({body.source} {loop})", count * body.low, count * body.high)
        word = "all" if node.kind == "forall" else "any"
        return Value(f"{word}({body.source} {loop})", 0, 1, truth=True)

    def _unrolled(self, node: ast.Quantified) -> Value:
        """The same, written out for each value."""
        low, high = self.bounds(node.type)
        repeats = self.repeated(high - low + 1, node.span)
        bodies = [
            self.binding(node.variable, value, repeats=repeats).value(node.body)
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

    def _call(self, node: ast.Call) -> Value:
        function = self.function(node)
        if function.result.kind == "void":
            raise fault(node.span, f"'{node.name}' returns nothing.", "Expected a number.")
        return Value(self.call(node, function), function.result.low, function.result.high)

    def function(self, node: ast.Call) -> Function:
        """The function that is called."""
        symbol = self.scope.get(node.name, node.span)
        if not isinstance(symbol, Function):
            raise fault(node.span, f"'{node.name}' is not a function.")
        return symbol

    def call(self, node: ast.Call, function: Function) -> str:
        """Source of a call.

        Raises:
            ModelError: the arguments are not those that the function takes.
        """
        expected, found = len(function.parameters), len(node.arguments)
        if expected != found:
            raise fault(node.span, f"'{function.name}' takes {expected} arguments, not {found}.")
        arguments = ["v", "r"]
        for parameter, argument in zip(function.parameters, node.arguments, strict=True):
            what = f"parameter '{parameter.name}' of '{function.name}'"
            if parameter.reference or parameter.type.dimensions:
                arguments.append(self._argument(parameter, argument, what))
            else:
                value = self.value(argument)
                arguments.append(self.checked(value, parameter.type, argument.span, what))
        self.repeated(function.effects.repeats, node.span)
        self.effects.add(function.effects)
        return f"{function.python}({', '.join(arguments)})"

    def _argument(self, parameter: FormalParameter, node: ast.Expression, what: str) -> str:
        term = self.term(node)
        if (
            isinstance(term, Value)
            and parameter.reference
            and term.known is None
            and isinstance(node, ast.Name)
        ):
            construct = f"'{node.name}', a scalar of a function passed by reference"
            raise refused(node.span, construct, "Return a value instead.")
        expected = parameter.type
        if not isinstance(term, StorageTerm) or term.type.shape != expected.shape:
            found = term.type if not isinstance(term, Value) else "a number"
            raise fault(node.span, f"'{node.span.snippet}' is {found}.", f"The {what} is {expected}.")
        same = (term.type.kind, term.type.low, term.type.high) == (expected.kind, expected.low, expected.high)
        if not same and not expected.constant:
            raise fault(node.span, f"'{node.span.snippet}' is {term.type}.", f"The {what} is {expected}.")
        self.read(term.storage)
        if not parameter.reference:
            return term.slice
        if not expected.constant:
            self.write(term.storage, node.span)
        return f"{term.storage.container}, {term.start}"


def _sum(bodies: list[Value]) -> Value:
    low, high = sum(body.low for body in bodies), sum(body.high for body in bodies)
    if all(body.known is not None for body in bodies):
        return Value.of(low)
    return Value("(" + " + ".join(body.source for body in bodies) + ")", low, high)
