"""Expressions of updates and functions: there an assignment has a value, and may stand inside another expression."""

from __future__ import annotations

from typing import Self

from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._scope import Function, Local, Storage
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import IndexedTerm, StorageTerm, Term, Value, arithmetic
from timed_automata.document import fault, refused
from timed_automata.language import ast


class ChangingExpressions(Expressions):
    """Compiles assignments as well.

    Python evaluates from left to right; UPPAAL promises no order. So what one part of an expression changes no other
    part may ask, but where `&&`, `||`, `imply` and `?:` say which comes first.
    """

    @classmethod
    def of(cls, expressions: Expressions) -> Self:
        """The same scope; what they touch is collected together."""
        changing = cls(expressions.code, expressions.scope, expressions.effects)
        changing.repeats = expressions.repeats
        return changing

    def constant(self, node: ast.Expression, what: str) -> int:
        """A number that is known before anything runs; see `Expressions.constant`."""
        return Expressions(self.code, self.scope).constant(node, what)

    def combined(self, old: Value, op: str, value: ast.Expression, node: ast.Node) -> Value:
        """What ``=``, ``+=``, … makes of an old value."""
        new = self.value(value)
        if op == "=":
            return new
        return arithmetic(op[:-1], old, new, lambda: self.code.site(node.span, f"'{node.span.snippet}'"))

    def fitted(self, value: Value, type_: Type, node: ast.Node, name: str) -> str:
        """Source of a value that is held in the range of what it is assigned to."""
        literal = isinstance(node, ast.Assignment) and node.op == "=" and isinstance(node.value, ast.Number)
        return self.checked(value, type_, node.span, name, literal=literal)

    def assigned(self, target: ast.Expression, op: str, value: ast.Expression, node: ast.Node) -> Value:
        """The new value of a scalar, as an expression that assigns it.

        Raises:
            ModelError: it is no scalar that can be assigned, or depends on the order of evaluation.
        """
        self.in_any_order(target, value)
        term = self.term(target)
        if isinstance(term, IndexedTerm) or (isinstance(term, StorageTerm) and term.type.dimensions):
            what = f"'{node.span.snippet}', an assignment of a clock or an array inside an expression"
            raise refused(node.span, what, "Assign it by itself.")
        name = target.span.snippet
        if isinstance(term, StorageTerm):
            self.write(term.storage, node.span)
            if op != "=":
                self.read(term.storage)
            at, container, type_ = self.code.name("t"), term.storage.container, term.type
            new = self.combined(Value(f"{container}[{at}]", type_.low, type_.high), op, value, node)
            source = f"_set({container}, ({at} := {term.start}), {self.fitted(new, type_, node, name)})"
            return Value(source, type_.low, type_.high)
        local = self.scope.find(target.name) if isinstance(target, ast.Name) else None
        if not isinstance(local, Local) or not local.written:
            raise fault(target.span, f"'{name}' cannot be assigned.", "Expected a variable.")
        type_ = local.type
        new = self.combined(Value(local.python, type_.low, type_.high), op, value, node)
        return Value(f"({local.python} := {self.fitted(new, type_, node, name)})", type_.low, type_.high)

    def in_any_order(self, *parts: ast.Expression) -> None:
        """Refuse parts of an expression of which one changes what another asks."""
        for index, part in enumerate(parts):
            if not (names := ast.changed(part)):
                continue
            asked = self._asked((*parts[:index], *parts[index + 1 :]))
            if both := [name for name in sorted(names) if self._place(name) in asked]:
                what = f"'{part.span.snippet}', which changes '{both[0]}' while the same expression asks it"
                raise refused(part.span, what, "It would depend on the order: write two expressions.")

    def call(self, node: ast.Call, function: Function) -> str:
        """Source of a call; see `Expressions.call`."""
        self.in_any_order(*node.arguments)
        return super().call(node, function)

    def _assignment(self, node: ast.Assignment) -> Value:
        return self.assigned(node.target, node.op, node.value, node)

    def _increment(self, node: ast.Increment) -> Value:
        op = node.op[0]
        new = self.assigned(node.target, f"{op}=", ast.Number(node.span, 1), node)
        if node.before:
            return new
        term = self.term(node.target)
        if isinstance(term, StorageTerm) and term.type.kind == "bool":
            raise refused(node.span, f"'{node.span.snippet}', the value of a bool before it is counted")
        back, by = ("-", 1) if op == "+" else ("+", -1)
        return Value(f"({new.source} {back} 1)", new.low - by, new.high - by)

    def _binary(self, node: ast.Binary) -> Value:
        if node.op not in ("&&", "||", "imply"):
            self.in_any_order(node.left, node.right)
        return super()._binary(node)

    def _index(self, node: ast.Index) -> Term:
        self.in_any_order(node.base, node.index)
        term = super()._index(node)
        if not isinstance(term, Value) and term.type.dimensions and ast.changed(node.index):
            raise refused(node.span, f"'{node.span.snippet}', an assignment in the index of a whole array")
        return term

    def _quantified(self, node: ast.Quantified) -> Value:
        if ast.changed(node.body):
            raise refused(node.span, f"'{node.span.snippet}', an assignment inside '{node.kind}'")
        return super()._quantified(node)

    def _asked(self, parts: tuple[ast.Expression, ...]) -> set[str]:
        """What expressions name, and what the functions that they call touch."""
        asked: set[str] = set()
        for node in ast.walk(parts):
            if isinstance(node, ast.Name):
                asked.add(self._place(node.name))
            elif isinstance(node, ast.Call) and isinstance(called := self.scope.find(node.name), Function):
                asked |= called.effects.reads | called.effects.writes
        return asked

    def _place(self, name: str) -> str:
        """A variable as effects name it."""
        symbol = self.scope.find(name)
        return symbol.name if isinstance(symbol, Storage) and symbol.shared else name
