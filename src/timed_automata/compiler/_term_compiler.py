"""What names and indices stand for, checked against their types: the part of expressions that needs no operators."""

from __future__ import annotations

from typing import Self

from timed_automata._limits import REPEATS
from timed_automata.compiler._generated_code import GeneratedCode
from timed_automata.compiler._scope import (
    Alias,
    ChannelSymbol,
    ClockSymbol,
    Constant,
    Effects,
    Local,
    Scope,
    Storage,
    Symbol,
)
from timed_automata.compiler._terms import IndexedTerm, StorageTerm, Term
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import Value
from timed_automata.document import Span, fault, refused
from timed_automata.language import ast


class TermCompiler:
    """Compiles what names and indices stand for in one scope; what they touch is collected in ``effects``.

    Subclasses add a method ``_<node>`` for each other kind of expression."""

    def __init__(self, code: GeneratedCode, scope: Scope, effects: Effects | None = None) -> None:
        self.code, self.scope = code, scope
        self.effects = effects if effects is not None else Effects()
        self.repeats = 1

    def inside(self, scope: Scope, *, repeats: int | None = None) -> Self:
        """The same in an inner scope, which is evaluated so often."""
        inner = type(self)(self.code, scope, self.effects)
        inner.repeats = self.repeats if repeats is None else repeats
        return inner

    def repeated(self, count: int, span: Span) -> int:
        """How often what is repeated ``count`` times here is evaluated; raises ModelError where that is too much."""
        total = self.repeats * max(count, 1)
        if total > REPEATS:
            what = f"'{span.snippet}' runs through {total} values, more than {REPEATS}."
            raise fault(span, what, "Take a smaller range.")
        self.effects.repeats = max(self.effects.repeats, total)
        return total

    def binding(self, name: str, value: int, *, repeats: int | None = None) -> Self:
        """The same in an inner scope where a name stands for a number."""
        scope = Scope(self.scope)
        scope.symbols[name] = Constant(name, Type("int", value, value), (value,), "")
        return self.inside(scope, repeats=repeats)

    # What callers ask for

    def value(self, node: ast.Expression) -> Value:
        """An integer or boolean expression.

        Raises:
            ModelError: it is something else, or not well-formed.
        """
        term = self.term(node)
        if isinstance(term, Value):
            return term
        if isinstance(term, IndexedTerm):
            if term.type.kind == "clock":
                raise refused(node.span, f"the clock '{term.name}' as a number", "Compare it with a number.")
            raise fault(node.span, f"'{node.span.snippet}' is a channel.", "Expected a number.")
        if term.type.dimensions:
            raise fault(node.span, f"'{node.span.snippet}' is an array.", "Expected a number.")
        if term.values is not None and not term.computed:
            return Value.of(term.values[term.offset])
        self.read(term.storage)
        if term.values is not None:
            return Value(term.source, min(term.values), max(term.values))
        return Value(term.source, term.type.low, term.type.high)

    def integer(self, node: ast.Expression) -> Value:
        """The same as a number: 0 or 1 for a truth."""
        return self.value(node).integer

    def constant(self, node: ast.Expression, what: str) -> int:
        """A number that is known before anything runs.

        Raises:
            ModelError: it depends on a variable.
        """
        inner = type(self)(self.code, self.scope, Effects())
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
        """Both ends of a bounded integer type, for a dimension, a quantifier, a select or a loop."""
        if type_.low is not None and type_.high is not None:
            return self.constant(type_.low, "A bound"), self.constant(type_.high, "A bound")
        if type_.base == "bool":
            return 0, 1
        symbol = None
        if type_.base not in ("int", "clock", "chan", "void"):
            symbol = self.scope.get(type_.base, type_.span)
        if isinstance(symbol, Alias) and symbol.type.integral and not symbol.type.dimensions:
            return symbol.type.low, symbol.type.high
        todo = "Expected int[low,high] or a name for it."
        raise fault(type_.span, f"'{type_.span.snippet}' is no bounded type.", todo)

    # Terms

    def term(self, node: ast.Expression) -> Term:
        """Whatever the expression stands for."""
        term: Term = getattr(self, f"_{type(node).__name__.lower()}")(node)
        return term

    def symbol(self, symbol: Symbol, span: Span) -> Term:
        """What a declared name stands for."""
        if isinstance(symbol, Constant):
            if not symbol.type.dimensions:
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
        raise refused(node.span, f"'{node.span.snippet}', a member", "The text of a model has no '.'.")

    def _braces(self, node: ast.Braces) -> Term:
        raise fault(node.span, "Braces stand only in the initialiser of an array.")

    def _assignment(self, node: ast.Assignment) -> Term:
        raise refused(
            node.span, f"'{node.span.snippet}', an assignment inside an expression", "Did you mean '=='?"
        )

    def _increment(self, node: ast.Increment) -> Term:
        raise refused(node.span, f"'{node.span.snippet}', an assignment inside an expression")

    # What is touched, and whether it fits

    def read(self, storage: Storage) -> None:
        """Note that something is read."""
        if storage.shared:
            self.effects.reads.add(storage.name)

    def write(self, storage: Storage, span: Span) -> None:
        """Note that something is assigned."""
        if not storage.written:
            raise fault(span, f"'{storage.name}' is constant and cannot be assigned.")
        if storage.shared:
            self.effects.writes.add(storage.name)

    def checked(self, value: Value, type_: Type, span: Span, what: str, *, literal: bool = False) -> str:
        """Source of a value made to fit a type: booleans become 0 or 1, integers are held in range."""
        if type_.kind == "bool":
            return value.boolean.source
        value = value.integer
        if value.within(type_.low, type_.high):
            return value.source
        if literal:
            raise fault(span, f"{what} = {value.known} is out of its range [{type_.low},{type_.high}].")
        return f"_range({value.source}, {type_.low}, {type_.high}, {self.code.site(span, what)})"
