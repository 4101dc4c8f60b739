"""Compiles updates (assignments, clock resets, calls of functions for their effect) and function bodies.

Generated code changes the values ``v`` (a list or an array) in place and appends the clocks that it sets to the list
``r``.
"""

from __future__ import annotations

from timed_automata.compiler._changing_expressions import ChangingExpressions
from timed_automata.compiler._declared_types import flatten, resolve_dimensions, resolve_type
from timed_automata.compiler._expressions import Expressions
from timed_automata.compiler._generated_code import LOOP_LIMIT
from timed_automata.compiler._scope import Alias, Local, Scope, Storage
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import IndexedTerm, StorageTerm, Value
from timed_automata.document import fault, refused
from timed_automata.language import ast


class Updates:
    """Collects the generated lines of one update."""

    def __init__(self, expressions: Expressions) -> None:
        self.expressions, self.code = ChangingExpressions.of(expressions), expressions.code
        self.lines: list[str] = []
        self.depth = 0

    def emit(self, line: str) -> None:
        """Add a line at the current indentation."""
        self.lines.append(" " * self.depth + line)

    def effect(self, node: ast.Expression) -> None:
        """Compile an expression that is evaluated for its effect.

        Raises:
            ModelError: it has no effect, or its target cannot be assigned.
        """
        if isinstance(node, ast.Assignment):
            self._assign(node.target, node.op, node.value, node)
        elif isinstance(node, ast.Increment):
            self._assign(node.target, f"{node.op[0]}=", ast.Number(node.span, 1), node)
        elif isinstance(node, ast.Call):
            self.emit(self.expressions.call(node, self.expressions.function(node)))
        else:
            if (word := node.span.snippet) in ("break", "continue") and not self.expressions.scope.find(word):
                raise refused(node.span, f"'{word}', this statement", "Put its condition into the loop's.")
            slip = isinstance(node, ast.Binary) and node.op == "=="
            todo = "Did you mean '='?" if slip else "Expected an assignment."
            raise fault(node.span, f"'{node.span.snippet}' has no effect.", todo)

    def _assign(self, target: ast.Expression, op: str, value: ast.Expression, node: ast.Node) -> None:
        self.expressions.in_any_order(target, value)
        if ast.changed(target) or ast.changed(value):
            term = self.expressions.term(target)
            if isinstance(term, StorageTerm) and term.type.single:
                self.emit(self.expressions.assigned(target, op, value, node).source)
                return
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
        elif not term.type.single:
            self._assign_whole(term, op, value, node)
        else:
            self._assign_scalar(term, op, value, node, target.span.snippet)

    def _assign_local(self, local: Local, op: str, value: ast.Expression, node: ast.Node) -> None:
        if not local.written:
            raise fault(node.span, f"'{local.name}' is constant and cannot be assigned.")
        new = self.expressions.combined(Value(local.python, local.type.low, local.type.high), op, value, node)
        self.emit(f"{local.python} = {self.expressions.fitted(new, local.type, node, local.name)}")

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
        new = self.expressions.combined(Value(place.source, place.type.low, place.type.high), op, value, node)
        self.emit(f"{place.source} = {self.expressions.fitted(new, place.type, node, name)}")

    def _assign_whole(self, place: StorageTerm, op: str, value: ast.Expression, node: ast.Node) -> None:
        """Assign an array or a structure."""
        source = self.expressions.term(value)
        if op != "=" or not isinstance(source, StorageTerm) or source.type.shape != place.type.shape:
            what = "an array" if place.type.dimensions else "a structure"
            raise fault(
                node.span, f"'{place.storage.name}' is {place.type}.", f"Expected '=' and {what} like it."
            )
        low, high = place.type.low, place.type.high
        fits = source.type.like(place.type)
        if source.values is not None and not place.type.fields:
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


class Statements(Updates):
    """Collects the generated lines of one function that returns ``result``."""

    def __init__(self, expressions: Expressions, result: Type) -> None:
        super().__init__(expressions)
        self.result = result

    def body(self, node: ast.Block) -> None:
        """Compile the whole body of a function; its own declarations share the scope of the parameters."""
        self._contents(node)
        if self.result.kind != "void":
            self.emit(f"_missing({self.code.site(node.span, 'The function')})")

    def _contents(self, node: ast.Block) -> None:
        for declaration in node.declarations:
            self._declare(declaration)
        for statement in node.statements:
            self._run(statement)

    def _run(self, node: ast.Statement) -> None:
        getattr(self, f"_{type(node).__name__.lower()}")(node)

    def _indented(self, node: ast.Statement) -> None:
        self.depth += 1
        self.emit("pass")
        self._run(node)
        self.depth -= 1

    def _block(self, node: ast.Block) -> None:
        outer = self.expressions
        self.expressions = outer.inside(Scope(outer.scope))
        self._contents(node)
        self.expressions = outer

    # Local variables

    def _declare(self, node: ast.Declaration) -> None:
        if isinstance(node, ast.FunctionDefinition):
            raise refused(node.span, f"'{node.name}', a function inside a function", "Declare it outside.")
        base = resolve_type(self.expressions, node.type)
        for declarator in node.declarators:
            type_ = resolve_dimensions(self.expressions, base, declarator)
            if isinstance(node, ast.TypeDefinition):
                symbol: Alias | Local | Storage = Alias(declarator.name, type_)
            elif not type_.integral:
                what = f"'{declarator.name}', {type_} in a function"
                raise refused(declarator.span, what, "Expected int or bool.")
            else:
                symbol = self._scalar(declarator, type_) if type_.single else self._whole(declarator, type_)
            self.expressions.scope.declare(declarator.name, symbol, declarator.span)

    def _scalar(self, node: ast.Declarator, type_: Type) -> Local:
        source = str(type_.default)
        if node.initialiser is not None:
            value = self.expressions.value(node.initialiser)
            source = self.expressions.checked(value, type_, node.span, node.name)
        python = self.code.name("l")
        self.emit(f"{python} = {source}")
        return Local(node.name, type_, python, written=not type_.constant)

    def _whole(self, node: ast.Declarator, type_: Type) -> Storage:
        """Declare an array or a structure."""
        scalars = [scalar for _, scalar in type_.scalars()]
        source = f"[{', '.join(str(scalar.default) for scalar in scalars)}]"
        if isinstance(node.initialiser, ast.Braces):
            items = flatten(node.initialiser, type_, node.name)
            values = [
                self.expressions.checked(self.expressions.value(item), scalar, item.span, node.name)
                for item, scalar in zip(items, scalars, strict=True)
            ]
            source = f"[{', '.join(values)}]"
        elif node.initialiser is not None:
            source = self._like(node.initialiser, type_, node.name)
        python = self.code.name("a")
        self.emit(f"{python} = {source}")
        return Storage(node.name, type_, python, 0, written=not type_.constant)

    def _like(self, node: ast.Expression, type_: Type, name: str) -> str:
        """Return the source of a copy of an array or a structure of this type."""
        term = self.expressions.term(node)
        if not isinstance(term, StorageTerm) or not term.type.like(type_):
            raise fault(node.span, f"'{node.span.snippet}' is no {type_}.", f"{name} is {type_}.")
        self.expressions.read(term.storage)
        return term.slice

    # Statements

    def _evaluate(self, node: ast.Evaluate) -> None:
        if node.expression is not None:
            self.effect(node.expression)

    def _if(self, node: ast.If) -> None:
        self.emit(f"if {self.expressions.value(node.test).source}:")
        self._indented(node.yes)
        if node.no is not None:
            self.emit("else:")
            self._indented(node.no)

    def _for(self, node: ast.For) -> None:
        for first in node.first:
            self.effect(first)
        self._head()
        if node.test is not None:
            self._leave_unless(node.test)
        self._indented(node.body)
        self.depth += 1
        for then in node.then:
            self.effect(then)
        self.depth -= 1
        self._end(node)

    def _dowhile(self, node: ast.DoWhile) -> None:
        self._head()
        self._indented(node.body)
        self._leave_unless(node.test)
        self._end(node)

    def _head(self) -> None:
        self.emit(f"for {self.code.name('n')} in range({LOOP_LIMIT}):")

    def _leave_unless(self, test: ast.Expression) -> None:
        self.emit(f" if not {self.expressions.value(test).source}: break")

    def _end(self, node: ast.Node) -> None:
        self.emit(f"else: _endless({self.code.site(node.span, node.span.snippet)})")

    def _iterate(self, node: ast.Iterate) -> None:
        low, high = self.expressions.bounds(node.type)
        outer, python = self.expressions, self.code.name("i")
        scope = Scope(outer.scope)
        scope.symbols[node.variable] = Local(node.variable, Type("int", low, high), python, written=False)
        self.expressions = outer.inside(scope, repeats=outer.repeated(high - low + 1, node.span))
        self.emit(f"for {python} in range({low}, {high + 1}):")
        self._indented(node.body)
        self.expressions = outer

    def _return(self, node: ast.Return) -> None:
        if self.result.kind == "void":
            if node.value is not None:
                raise fault(node.span, "A void function returns no value.")
            self.emit("return")
            return
        if node.value is None:
            raise fault(node.span, f"A value of type {self.result} is expected after 'return'.")
        if not self.result.single:
            self.emit(f"return {self._like(node.value, self.result, 'The result')}")
            return
        value = self.expressions.value(node.value)
        self.emit(f"return {self.expressions.checked(value, self.result, node.span, 'The result')}")
