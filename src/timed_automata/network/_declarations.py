"""Processes declarations: places for variables, clocks and channels, values for constants, code for functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from timed_automata.compiler import (
    Alias,
    ChannelSymbol,
    ClockSymbol,
    Constant,
    Expressions,
    FormalParameter,
    Function,
    GeneratedCode,
    Local,
    Scope,
    Statements,
    Storage,
    StorageTerm,
    Symbol,
    Type,
    flatten,
    resolve_dimensions,
    resolve_type,
)
from timed_automata.document import Span, fault, refused
from timed_automata.errors import UsageError
from timed_automata.language import ast
from timed_automata.network._network import Channel, Given, Variable


class Places:
    """The variables, clocks and channels with a place so far. Clock 0 is the reference clock, always zero."""

    def __init__(self) -> None:
        self.variables: list[Variable] = []
        self.offsets: dict[str, int] = {}
        self.initial: list[int] = []
        self.clocks: list[str] = ["0"]
        self.channels: list[Channel] = []

    def variable(self, name: str, type_: Type, values: list[int]) -> int:
        """Add a variable with its initial values; return its offset in the values."""
        offset = len(self.initial)
        self.variables.append(Variable(name, type_, offset))
        self.offsets |= {element: offset + n for n, (element, _) in enumerate(type_.scalars(name))}
        self.initial += values
        return offset

    def clock(self, name: str, type_: Type) -> int:
        """Add a clock or an array of clocks; return the number of the first."""
        self.clocks += [each for each, _ in type_.scalars(name)]
        return len(self.clocks) - type_.size

    def channel(self, name: str, type_: Type) -> int:
        """Add a channel or an array of channels; return the number of the first."""
        self.channels += [Channel(each, type_.broadcast, type_.urgent) for each, _ in type_.scalars(name)]
        return len(self.channels) - type_.size


class Declarations:
    """Adds declarations to a scope.

    ``given`` replaces the initialisers of constants; ``prefix`` names the process; ``replaced`` collects the replaced
    initialisers, for writing the file back.
    """

    def __init__(
        self,
        code: GeneratedCode,
        places: Places,
        scope: Scope,
        *,
        prefix: str = "",
        given: Mapping[str, Given] | None = None,
    ) -> None:
        self.code, self.places, self.scope, self.prefix = code, places, scope, prefix
        self.given = given or {}
        self.replaced: list[tuple[Span, str]] = []
        self.expressions = Expressions(code, scope)

    def declare(self, node: ast.Declaration) -> None:
        """Add one declaration."""
        if isinstance(node, ast.FunctionDefinition):
            self._function(node)
            return
        base = resolve_type(self.expressions, node.type)
        for declarator in node.declarators:
            type_ = resolve_dimensions(self.expressions, base, declarator)
            if isinstance(node, ast.TypeDefinition):
                symbol: Symbol = Alias(declarator.name, type_)
            elif not type_.integral:
                symbol = self._clock_or_channel(declarator, type_)
            elif type_.constant:
                symbol = self._constant(declarator, type_)
            else:
                symbol = self._variable(declarator, type_)
            self.scope.declare(declarator.name, symbol, declarator.span)

    def _clock_or_channel(self, node: ast.Declarator, type_: Type) -> Symbol:
        if node.initialiser is not None:
            raise fault(node.span, f"A {type_.kind} has no initialiser.")
        name = self.prefix + node.name
        if type_.kind == "clock":
            return ClockSymbol(name, type_, self.places.clock(name, type_))
        return ChannelSymbol(name, type_, self.places.channel(name, type_))

    def _constant(self, node: ast.Declarator, type_: Type) -> Constant:
        if node.initialiser is None:
            raise fault(node.span, f"The constant '{node.name}' has no value.", "Expected '='.")
        if not self.prefix and node.name in self.given:
            given = self.given[node.name]
            values = _flatten_given(given, type_, node.name)
            self.replaced.append((node.initialiser.span, _as_source(given, type_)))
        else:
            values = self._values(node.initialiser, type_, node.name)
        return self.constant(node.name, type_, values)

    def constant(self, name: str, type_: Type, values: list[int]) -> Constant:
        """Return a constant with known values."""
        container = "" if type_.single else self.code.constant(tuple(values))
        return Constant(name, type_, tuple(values), container)

    def _values(self, node: ast.Expression, type_: Type, name: str) -> list[int]:
        if isinstance(node, ast.Name | ast.Index | ast.Member) and not type_.single:
            term = self.expressions.term(node)
            if isinstance(term, StorageTerm) and term.known is not None and term.type.shape == type_.shape:
                return list(term.known)
        scalars = (scalar for _, scalar in type_.scalars())
        items = flatten(node, type_, name)
        return [self._number(item, scalar, name) for item, scalar in zip(items, scalars, strict=True)]

    def _number(self, node: ast.Expression, type_: Type, name: str) -> int:
        number = self.expressions.constant(node, f"The value of '{name}'")
        if type_.kind == "bool":
            return int(number != 0)
        if not type_.low <= number <= type_.high:
            raise fault(node.span, f"{name} = {number} is out of its range [{type_.low},{type_.high}].")
        return number

    def _variable(self, node: ast.Declarator, type_: Type) -> Storage:
        if node.initialiser is None:
            values = [scalar.default for _, scalar in type_.scalars()]
        else:
            values = self._values(node.initialiser, type_, node.name)
        name = self.prefix + node.name
        return Storage(name, type_, "v", self.places.variable(name, type_, values))

    def _function(self, node: ast.FunctionDefinition) -> None:
        result = resolve_type(self.expressions, node.result)
        if not (result.integral or result.kind == "void") or result.dimensions:
            todo = "Give it a parameter by reference, or a structure to return."
            raise refused(node.result.span, f"a function that returns {result}", todo)
        body = self.expressions.inside(Scope(self.scope))
        body.effects = type(body.effects)()
        names = ["v", "r"]
        parameters = tuple(self._parameter(parameter, body, names) for parameter in node.parameters)
        statements = Statements(body, result)
        statements.body(node.body)
        python = self.code.name("f")
        self.code.function(python, ", ".join(names), statements.lines)
        function = Function(node.name, parameters, result, python, body.effects)
        self.scope.declare(node.name, function, node.span)

    def _parameter(self, node: ast.Parameter, body: Expressions, names: list[str]) -> FormalParameter:
        type_ = resolve_dimensions(body, resolve_type(body, node.type), node.declarator)
        name, python = node.declarator.name, self.code.name("p")
        if not type_.integral:
            raise refused(node.span, f"'{name}', {type_} as parameter of a function", "Expected int or bool.")
        writable = not type_.constant
        names.append(python)
        if node.reference:
            names.append(f"{python}o")
            symbol: Symbol = Storage(name, type_, python, f"{python}o", written=writable)
        elif not type_.single:
            symbol = Storage(name, type_, python, 0, written=writable)
        else:
            symbol = Local(name, type_, python, written=writable)
        body.scope.declare(name, symbol, node.span)
        return FormalParameter(name, type_, node.reference)


def _flatten_given(value: Given, type_: Type, name: str) -> list[int]:
    """Return the scalars of a constant given from outside.

    Raises:
        UsageError: its shape, a type or a range differs from the declaration.
    """
    if parts := type_.parts:
        if isinstance(value, str | int) or not isinstance(value, Sequence) or len(value) != len(parts):
            raise UsageError(f"The constant '{name}' needs a list of {len(parts)} values, not {value!r}.")
        return [
            scalar
            for item, (_, part) in zip(value, parts, strict=True)
            for scalar in _flatten_given(item, part, name)
        ]
    if not isinstance(value, int) or (isinstance(value, bool) and type_.kind != "bool"):
        raise UsageError(f"The constant '{name}' needs {type_.kind} values, not {value!r}.")
    if not type_.low <= value <= type_.high:
        raise UsageError(f"The constant '{name}' = {value} is outside of {type_.low} to {type_.high}.")
    return [int(value)]


def _as_source(value: Given, type_: Type) -> str:
    """Return a constant in UPPAAL's language."""
    if isinstance(value, Sequence):
        return "{" + ", ".join(_as_source(item, type_) for item in value) + "}"
    return ("true" if value else "false") if type_.kind == "bool" else str(int(value))
