"""Compiles expressions of updates and functions, where an assignment has a value and may be part of another
expression.
"""

from __future__ import annotations

from typing import Self

from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._scope import Function, Local, Storage
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import IndexedTerm, StorageTerm, Term, Value, arithmetic
from timed_automata.document import fault, refused
from timed_automata.language import ast


class ChangingExpressions(Expressions):
    """Compiles expressions that may contain assignments.

    Python evaluates from left to right; UPPAAL promises no order. Therefore a variable that one part of an expression
    changes must not be read by another part, unless `&&`, `||`, `imply` or `?:` fixes the order.
    """

    @classmethod
    def of(cls, expressions: Expressions) -> Self:
        """Return a compiler with the same scope that adds to the same effects."""
        changing = cls(expressions.code, expressions.scope, expressions.effects)
        changing.repeats = expressions.repeats
        return changing

    def constant(self, node: ast.Expression, what: str) -> int:
        """Return a number that is known before the network runs; see `Expressions.constant`."""
        return Expressions(self.code, self.scope).constant(node, what)

    def combined(self, old: Value, op: str, value: ast.Expression, node: ast.Node) -> Value:
        """Return the value that ``=``, ``+=``, … computes from an old value."""
        new = self.value(value)
        if op == "=":
            return new
        return arithmetic(op[:-1], old, new, lambda: self.code.site(node.span, f"'{node.span.snippet}'"))

    def fitted(self, value: Value, type_: Type, node: ast.Node, name: str) -> str:
        """Return the source of a value that is checked against the range of its target."""
        literal = isinstance(node, ast.Assignment) and node.op == "=" and isinstance(node.value, ast.Number)
        return self.checked(value, type_, node.span, name, literal=literal)

    def assigned(self, target: ast.Expression, op: str, value: ast.Expression, node: ast.Node) -> Value:
        """Return the new value of a scalar as an expression that also assigns it.

        Raises:
            ModelError: the target is not an assignable scalar, or the result depends on the order of evaluation.
        """
        self.in_any_order(target, value)
        term = self.term(target)
        if isinstance(term, IndexedTerm) or (isinstance(term, StorageTerm) and not term.type.single):
            what = f"'{node.span.snippet}', an assignment of a clock, an array or a structure inside an expression"
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
        """Refuse an expression in which one part changes a variable that another part reads."""
        for index, part in enumerate(parts):
            if not (names := ast.changed(part)):
                continue
            asked = self._asked((*parts[:index], *parts[index + 1 :]))
            if both := [name for name in sorted(names) if _overlaps(self._place(name), asked)]:
                what = f"'{part.span.snippet}', which changes '{both[0]}' while the same expression reads it"
                raise refused(
                    part.span,
                    what,
                    "The result would depend on the order: write two expressions.",
                )

    def call(self, node: ast.Call, function: Function) -> str:
        """Return the source of a call; see `Expressions.call`."""
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
            what = f"'{node.span.snippet}', the value of a bool before '++' or '--'"
            raise refused(node.span, what, "Read it in an update of its own, before the change.")
        back, by = ("-", 1) if op == "+" else ("+", -1)
        return Value(f"({new.source} {back} 1)", new.low - by, new.high - by)

    def _binary(self, node: ast.Binary) -> Value:
        if node.op not in ("&&", "||", "imply"):
            self.in_any_order(node.left, node.right)
        return super()._binary(node)

    def _index(self, node: ast.Index) -> Term:
        self.in_any_order(node.base, node.index)
        term = super()._index(node)
        if not isinstance(term, Value) and not term.type.single and ast.changed(node.index):
            what = f"'{node.span.snippet}', an assignment in the index of a whole array"
            raise refused(node.span, what, "Change the index in an update of its own.")
        return term

    def _quantified(self, node: ast.Quantified) -> Value:
        if ast.changed(node.body):
            what = f"'{node.span.snippet}', an assignment inside '{node.kind}'"
            raise refused(node.span, what, "Write a function with a loop.")
        return super()._quantified(node)

    def _asked(self, parts: tuple[ast.Expression, ...]) -> set[str]:
        """Return the names that the expressions use, and those that the functions called in them read or write."""
        asked = set(map(self._place, ast.paths(parts)))
        for node in ast.walk(parts):
            if isinstance(node, ast.Call) and isinstance(called := self.scope.find(node.name), Function):
                asked |= called.effects.reads | called.effects.writes
        return asked

    def _place(self, path: str) -> str:
        """Return a path with the name under which effects list the variable."""
        name, dot, fields = path.partition(".")
        symbol = self.scope.find(name)
        return f"{symbol.name}{dot}{fields}" if isinstance(symbol, Storage) and symbol.shared else path


def _overlaps(path: str, others: set[str]) -> bool:
    """Return whether a variable, or a field of it, is one of the others, or a part of one, or contains one."""
    return any(f"{path}.".startswith(f"{other}.") or f"{other}.".startswith(f"{path}.") for other in others)
