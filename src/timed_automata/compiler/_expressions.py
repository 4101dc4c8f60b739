"""Type-checks expressions and compiles them to Python source over the vector of values ``v``."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any, Self

from timed_automata._limits import LONGEST_BITS, REPEATS
from timed_automata.compiler._generated_code import GeneratedCode
from timed_automata.compiler._scope import (
    Alias,
    ChannelSymbol,
    ClockSymbol,
    Constant,
    Effects,
    FormalParameter,
    Function,
    Local,
    Scope,
    Storage,
    Symbol,
)
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import (
    COMPARISONS,
    IndexedTerm,
    StorageTerm,
    Term,
    Value,
    arithmetic,
    comparison,
    conditional,
    logical,
    negation,
    signed,
)
from timed_automata.document import Span, did_you_mean, fault, refused
from timed_automata.errors import RangeError
from timed_automata.language import ast

_UNROLL = 8  # quantifiers over at most so many values become plain code, which is faster


class Expressions:
    """Compiles the expressions of one scope; ``effects`` collects the names that they read and write."""

    arguments = "v, r=None"
    """Parameters of the functions to which conditions are compiled."""

    def __init__(self, code: GeneratedCode, scope: Scope, effects: Effects | None = None) -> None:
        self.code, self.scope = code, scope
        self.effects = effects if effects is not None else Effects()
        self.repeats = 1

    def inside(self, scope: Scope, *, repeats: int | None = None) -> Self:
        """Return this compiler for an inner scope that is evaluated ``repeats`` times."""
        inner = copy(self)
        inner.scope, inner.repeats = scope, self.repeats if repeats is None else repeats
        return inner

    def repeated(self, count: int, span: Span) -> int:
        """Return how often a part that is repeated ``count`` times here is evaluated.

        Raises:
            ModelError: it is evaluated more often than the limit allows.
        """
        total = self.repeats * max(count, 1)
        if total > REPEATS:
            what = f"'{span.snippet}' runs through {total} values, more than {REPEATS}."
            raise fault(span, what, "Take a smaller range.")
        self.effects.repeats = max(self.effects.repeats, total)
        return total

    def binding(self, name: str, value: int, *, repeats: int | None = None) -> Self:
        """Return this compiler for an inner scope in which a name has a fixed number as its value."""
        scope = Scope(self.scope)
        scope.symbols[name] = Constant(name, Type("int", value, value), (value,), "")
        return self.inside(scope, repeats=repeats)

    # What callers ask for

    def value(self, node: ast.Expression) -> Value:
        """Compile an integer or boolean expression.

        Raises:
            ModelError: the expression has another type, or is not well-formed.
        """
        try:
            term = self.term(node)
        except RecursionError:  # of each level until one has room for the sentence
            raise fault(node.span, "This is nested too deeply.", "Break it into parts.") from None
        if isinstance(term, Value):
            return term
        if isinstance(term, IndexedTerm):
            if term.type.kind == "clock":
                raise refused(node.span, f"the clock '{term.name}' as a number", "Compare it with a number.")
            raise fault(node.span, f"'{node.span.snippet}' is a channel.", "Expected a number.")
        if not term.type.single:
            kind = "an array" if term.type.dimensions else "a structure"
            raise fault(node.span, f"'{node.span.snippet}' is {kind}.", "Expected a number.")
        if term.values is not None and not term.computed:
            return Value.of(term.values[term.offset])
        self.read(term.storage)
        if term.values is not None:
            return Value(term.source, min(term.values), max(term.values))
        return Value(term.source, term.type.low, term.type.high)

    def integer(self, node: ast.Expression) -> Value:
        """Compile an integer or boolean expression to a number; true is 1 and false is 0."""
        return self.value(node).integer

    def constant(self, node: ast.Expression, what: str) -> int:
        """Return the value of an expression that must be known before the network runs.

        Raises:
            ModelError: it depends on a variable.
        """
        inner = copy(self)
        inner.effects = Effects()
        value = inner.integer(node)
        if value.known is not None:
            return value.known
        touched = inner.effects.reads | inner.effects.writes
        if touched:
            names = ", ".join(sorted(touched))
            raise fault(node.span, f"{what} must be constant; '{node.span.snippet}' depends on {names}.")
        try:
            number: int = self.code.expression("v, r", value.source)((), None)
        except NameError:  # a local variable of a function
            raise fault(node.span, f"{what} must be constant; '{node.span.snippet}' is not.") from None
        return number

    def bounds(self, type_: ast.TypeName) -> tuple[int, int]:
        """Return both ends of a bounded integer type, for a dimension, a quantifier, a select or a loop."""
        if type_.low is not None and type_.high is not None:
            return self.constant(type_.low, "A bound"), self.constant(type_.high, "A bound")
        if type_.base == "bool":
            return 0, 1
        symbol = None
        if type_.base not in ("int", "clock", "chan", "void"):
            symbol = self.scope.get(type_.base, type_.span)
        if isinstance(symbol, Alias) and symbol.type.integral and symbol.type.single:
            return symbol.type.low, symbol.type.high
        todo = "Expected int[low,high] or a name for it."
        raise fault(type_.span, f"'{type_.span.snippet}' is no bounded type.", todo)

    def function_of(self, source: str) -> Callable[..., Any]:
        """Return the generated code as a function of a discrete state."""
        return self.code.expression(self.arguments, source)

    def is_clock(self, node: ast.Node) -> bool:
        """Return whether the node is the name of a clock or of an array of clocks."""
        return isinstance(node, ast.Name) and isinstance(self.scope.find(node.name), ClockSymbol)

    def mentions_clock(self, node: ast.Expression) -> bool:
        """Return whether a clock occurs anywhere in an expression."""
        return any(map(self.is_clock, ast.walk(node)))

    # Terms

    def term(self, node: ast.Expression) -> Term:
        """Compile an expression to a value, a storage place, or a clock or channel."""
        term: Term = getattr(self, f"_{type(node).__name__.lower()}")(node)
        return term

    def symbol(self, symbol: Symbol, span: Span) -> Term:
        """Return the term that a declared name denotes."""
        if isinstance(symbol, Constant):
            if symbol.type.single:
                return Value.of(symbol.values[0])
            storage = Storage(symbol.name, symbol.type, symbol.container, 0, written=False)
            return StorageTerm(storage, symbol.type, values=symbol.values)
        if isinstance(symbol, Storage):
            return StorageTerm(symbol, symbol.type)
        if isinstance(symbol, Local):
            return Value(symbol.python, symbol.type.low, symbol.type.high)
        if isinstance(symbol, ClockSymbol | ChannelSymbol):
            return IndexedTerm(symbol.name, symbol.type, symbol.base, size=symbol.type.size)
        kind = "type" if isinstance(symbol, Alias) else "function"
        raise fault(span, f"'{symbol.name}' is a {kind}.", "Expected a value.")

    def _number(self, node: ast.Number) -> Value:
        return Value.of(node.value)

    def _name(self, node: ast.Name) -> Term:
        return self.symbol(self.scope.get(node.name, node.span), node.span)

    def _index(self, node: ast.Index) -> Term:
        base = self.term(node.base)
        if isinstance(base, Value) or not base.type.dimensions:
            raise fault(node.span, f"'{node.base.span.snippet}' is no array.", "Remove the index.")
        index = self.integer(node.index)
        low, high = base.type.dimensions[0]
        element, what = base.type.element, f"'{node.base.span.snippet}'"
        offset, computed = base.offset, base.computed
        if index.known is not None and low <= index.known <= high:
            offset += (index.known - low) * element.size
        elif isinstance(node.index, ast.Number):
            raise fault(node.index.span, f"Index {index.known} of {what} is outside of {low} to {high}.")
        else:  # a constant index out of range is reported when it is used: a guard may prevent that
            source = index.source
            if not index.within(low, high):
                source = f"_index({source}, {low}, {high}, {self.code.site(node.index.span, what)})"
            source = f"({source} - {low})" if low else source
            source = f"{source} * {element.size}" if element.size != 1 else source
            computed = f"{computed} + {source}" if computed else source
        if isinstance(base, StorageTerm):
            return StorageTerm(base.storage, element, offset, computed, base.values)
        return IndexedTerm(base.name, element, base.base, offset, computed, base.size)

    def _member(self, node: ast.Member) -> Term:
        if isinstance(node.base, ast.Name) and self.scope.find(node.base.name) is None:
            todo = "Only queries name what belongs to a process: declare it for all processes."
            raise refused(node.span, f"'{node.span.snippet}', a member", todo)
        base = self.term(node.base)
        if not isinstance(base, StorageTerm) or base.type.dimensions or not base.type.fields:
            raise fault(node.base.span, f"'{node.base.span.snippet}' is no structure.", "Remove the field.")
        offset = base.offset
        for name, type_ in base.type.fields:
            if name == node.name:
                return StorageTerm(base.storage, type_, offset, base.computed, base.values)
            offset += type_.size
        advice = did_you_mean(node.name, (name for name, _ in base.type.fields))
        raise fault(node.span, f"'{node.base.span.snippet}' has no field '{node.name}'.", advice)

    def _braces(self, node: ast.Braces) -> Term:
        raise fault(node.span, "Braces are allowed only in the initialiser of an array.")

    def _assignment(self, node: ast.Assignment) -> Term:
        what = f"'{node.span.snippet}', an assignment inside an expression"
        raise refused(node.span, what, "Did you mean '=='?")

    def _increment(self, node: ast.Increment) -> Term:
        what = f"'{node.span.snippet}', an assignment inside an expression"
        raise refused(node.span, what, "Only an update may change a variable.")

    # Operators

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
        if not (isinstance(left, StorageTerm) and isinstance(right, StorageTerm)) or left.type.single:
            return comparison(node.op, self.value(node.left), self.value(node.right))
        if left.type.shape != right.type.shape or node.op not in ("==", "!="):
            raise fault(node.span, f"'{left.type}' and '{right.type}' cannot be compared by '{node.op}'.")
        self.read(left.storage)
        self.read(right.storage)
        return Value(f"({left.slice} {node.op} {right.slice})", 0, 1, truth=True)

    def _conditional(self, node: ast.Conditional) -> Value:
        return conditional(self.value(node.test), self.value(node.yes), self.value(node.no))

    def _quantified(self, node: ast.Quantified) -> Value:
        """Compile a quantifier or a sum."""
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
        """Compile a quantifier or a sum with its body repeated for each value."""
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

    # Calls

    def _call(self, node: ast.Call) -> Term:
        function = self.function(node)
        if function.result.kind == "void":
            raise fault(node.span, f"'{node.name}' returns nothing.", "Expected a number.")
        source, result = self.call(node, function), function.result
        if not result.single:  # a list, which the call makes
            return StorageTerm(Storage(function.name, result, source, written=False), result)
        return Value(source, result.low, result.high)

    def function(self, node: ast.Call) -> Function:
        """Return the function that a call names."""
        if node.process is not None:
            todo = "Only queries name what belongs to a process: declare it for all processes."
            raise refused(node.span, f"'{node.span.snippet}', a member", todo)
        symbol = self.scope.get(node.name, node.span)
        if not isinstance(symbol, Function):
            raise fault(node.span, f"'{node.name}' is not a function.")
        return symbol

    def call(self, node: ast.Call, function: Function) -> str:
        """Return the source of a call.

        Raises:
            ModelError: the arguments do not fit the parameters of the function.
        """
        expected, found = len(function.parameters), len(node.arguments)
        if expected != found:
            raise fault(node.span, f"'{function.name}' takes {expected} arguments, not {found}.")
        arguments = ["v", "r"]
        for parameter, argument in zip(function.parameters, node.arguments, strict=True):
            what = f"parameter '{parameter.name}' of '{function.name}'"
            if parameter.reference or not parameter.type.single:
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

    # What is touched, and whether it fits

    def read(self, storage: Storage) -> None:
        """Record that a variable is read."""
        if storage.shared:
            self.effects.reads.add(storage.name)

    def write(self, storage: Storage, span: Span) -> None:
        """Record that a variable is assigned; raise ModelError if it is constant."""
        if not storage.written:
            raise fault(span, f"'{storage.name}' is constant and cannot be assigned.")
        if storage.shared:
            self.effects.writes.add(storage.name)

    def checked(self, value: Value, type_: Type, span: Span, what: str, *, literal: bool = False) -> str:
        """Return the source of a value made to fit a type: booleans become 0 or 1, integers are checked against the
        range.
        """
        if type_.kind == "bool":
            return value.boolean.source
        value = value.integer
        if value.within(type_.low, type_.high):
            return value.source
        if literal:
            raise fault(span, f"{what} = {value.known} is out of its range [{type_.low},{type_.high}].")
        return f"_range({value.source}, {type_.low}, {type_.high}, {self.code.site(span, what)})"


def _sum(bodies: list[Value]) -> Value:
    low, high = sum(body.low for body in bodies), sum(body.high for body in bodies)
    if all(body.known is not None for body in bodies):
        return Value.of(low)
    return Value("(" + " + ".join(body.source for body in bodies) + ")", low, high)
