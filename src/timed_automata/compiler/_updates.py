"""Compiling updates: assignments, resets of clocks, calls for what they do.

Generated code changes the values ``v`` (a list or an array) in place and appends the clocks that it sets to the list
``r``.
"""

from __future__ import annotations

from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._scope import Local
from timed_automata.compiler._terms import IndexedTerm, StorageTerm
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import Value, arithmetic
from timed_automata.document import fault, refused
from timed_automata.language import ast


class Updates:
    """Collects the lines of one update."""

    def __init__(self, expressions: Expressions) -> None:
        self.expressions, self.code = expressions, expressions.code
        self.lines: list[str] = []
        self.depth = 0

    def emit(self, line: str) -> None:
        """Add a line at the present depth."""
        self.lines.append(" " * self.depth + line)

    def effect(self, node: ast.Expression) -> None:
        """An expression for what it does.

        Raises:
            ModelError: it does nothing, or assigns to something that cannot be assigned.
        """
        if isinstance(node, ast.Assignment):
            self._assign(node.target, node.op, node.value, node)
        elif isinstance(node, ast.Increment):
            self._assign(node.target, f"{node.op[0]}=", ast.Number(node.span, 1), node)
        elif isinstance(node, ast.Call):
            self.emit(self.expressions.call(node, self.expressions.function(node)))
        else:
            slip = isinstance(node, ast.Binary) and node.op == "=="
            todo = "Did you mean '='?" if slip else "Expected an assignment."
            raise fault(node.span, f"'{node.span.snippet}' has no effect.", todo)

    def _assign(self, target: ast.Expression, op: str, value: ast.Expression, node: ast.Node) -> None:
        if isinstance(target, ast.Name):
            local = self.expressions.scope.get(target.name, target.span)
            if isinstance(local, Local):
                self._assign_local(local, op, value, node)
                return
        if not isinstance(target, ast.Name | ast.Index | ast.Member):
            raise fault(target.span, f"'{target.span.snippet}' cannot be assigned.", "Expected a variable.")
        term = self.expressions.term(target)
        if isinstance(term, IndexedTerm):
            self._set_clock(term, op, value, node)
        elif isinstance(term, Value):
            raise fault(target.span, f"'{target.span.snippet}' is constant and cannot be assigned.")
        elif term.type.dimensions:
            self._assign_array(term, op, value, node)
        else:
            self._assign_scalar(term, op, value, node, target.span.snippet)

    def _assign_local(self, local: Local, op: str, value: ast.Expression, node: ast.Node) -> None:
        if not local.written:
            raise fault(node.span, f"'{local.name}' is constant and cannot be assigned.")
        new = self._combined(Value(local.python, local.type.low, local.type.high), op, value, node)
        self.emit(f"{local.python} = {self._checked(new, local.type, node, local.name)}")

    def _assign_scalar(
        self, place: StorageTerm, op: str, value: ast.Expression, node: ast.Node, name: str
    ) -> None:
        self.expressions.write(place.storage, node.span)
        if op != "=":
            self.expressions.read(place.storage)
            if place.computed:  # the index is evaluated once
                index = self.code.name("t")
                self.emit(f"{index} = {place.computed}")
                place = StorageTerm(place.storage, place.type, place.offset, index)
        new = self._combined(Value(place.source, place.type.low, place.type.high), op, value, node)
        self.emit(f"{place.source} = {self._checked(new, place.type, node, name)}")

    def _checked(self, value: Value, type_: Type, node: ast.Node, name: str) -> str:
        literal = isinstance(node, ast.Assignment) and node.op == "=" and isinstance(node.value, ast.Number)
        return self.expressions.checked(value, type_, node.span, name, literal=literal)

    def _combined(self, old: Value, op: str, value: ast.Expression, node: ast.Node) -> Value:
        new = self.expressions.value(value)
        if op == "=":
            return new
        return arithmetic(op[:-1], old, new, lambda: self.code.site(node.span, f"'{node.span.snippet}'"))

    def _assign_array(self, place: StorageTerm, op: str, value: ast.Expression, node: ast.Node) -> None:
        source = self.expressions.term(value)
        if op != "=" or not isinstance(source, StorageTerm) or source.type.shape != place.type.shape:
            raise fault(
                node.span, f"'{place.storage.name}' is {place.type}.", "Expected '=' and such an array."
            )
        low, high = place.type.low, place.type.high
        fits = (source.type.low, source.type.high) == (low, high)
        if source.values is not None:
            fits = all(low <= value <= high for value in source.values)
        if not fits:
            raise fault(node.span, f"'{value.span.snippet}' is {source.type}, not {place.type}.")
        self.expressions.write(place.storage, node.span)
        self.expressions.read(source.storage)
        at, scalar = self.code.name("t"), self.code.name("t")
        self.emit(f"for {at}, {scalar} in enumerate({source.slice}, {place.start}):")
        self.emit(f" {place.storage.container}[{at}] = {scalar}")

    def _set_clock(self, term: IndexedTerm, op: str, value: ast.Expression, node: ast.Node) -> None:
        if term.type.kind != "clock":
            raise fault(node.span, f"'{term.name}' is a channel and cannot be assigned.")
        if term.type.dimensions or op != "=":
            raise refused(
                node.span, f"'{node.span.snippet}', this change of a clock", "Expected 'clock = number'."
            )
        number = self.expressions.integer(value)
        self.expressions.effects.writes.add(term.name)
        source = number.source
        if number.low < 0:
            site = self.code.site(node.span, f"The clock {term.name}")
            source = f"_range({source}, 0, {max(number.high, 0)}, {site})"
        self.emit(f"r.append(({term.source}, {source}))")
