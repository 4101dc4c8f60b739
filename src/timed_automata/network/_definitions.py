"""The system section: its definitions, and the processes of the ``system`` line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import product
from math import prod

from timed_automata._limits import PROCESSES
from timed_automata.compiler import (
    ChannelSymbol,
    ClockSymbol,
    Constant,
    Expressions,
    GeneratedCode,
    IndexedTerm,
    Scope,
    Storage,
    StorageTerm,
    Symbol,
    Term,
    Type,
    resolve_dimensions,
    resolve_type,
)
from timed_automata.document import did_you_mean, fault
from timed_automata.language import ast
from timed_automata.network._declarations import Places
from timed_automata.network._network import Process
from timed_automata.network._templates import ParsedTemplate, make_process


@dataclass(frozen=True, slots=True, eq=False)
class _Definition:
    """A template, or a partial instantiation of another definition; ``scope`` is the scope of the definition."""

    name: str
    parameters: tuple[ast.Parameter, ...]
    scope: Scope
    template: ParsedTemplate | None = None
    instantiation: ast.Instantiation | None = None


class Definitions:
    """Templates and their instantiations, by name; collects the ``processes`` that are made from them."""

    def __init__(self, code: GeneratedCode, places: Places) -> None:
        self.code, self.places = code, places
        self.processes: list[Process] = []
        self._by_name: dict[str, _Definition] = {}

    def add_template(self, parsed: ParsedTemplate, scope: Scope) -> None:
        """Add a template."""
        definition = _Definition(parsed.name, parsed.parameters, scope, template=parsed)
        self._add(definition, ast.Node(parsed.template.name.whole))

    def add_instantiation(self, node: ast.Instantiation, scope: Scope) -> None:
        """Add an instantiation ``name(parameters) = template(arguments);``."""
        template = self._get(node.template)
        expected, found = len(template.parameters), len(node.arguments)
        if expected != found:
            raise fault(node.span, f"'{template.name}' takes {expected} arguments, not {found}.")
        self._add(_Definition(node.name, node.parameters, scope, instantiation=node), node)

    def _add(self, definition: _Definition, node: ast.Node) -> None:
        if definition.name in self._by_name:
            raise fault(node.span, f"'{definition.name}' is declared twice.")
        self._by_name[definition.name] = definition

    def _get(self, name: ast.Name) -> _Definition:
        if name.name not in self._by_name:
            todo = did_you_mean(name.name, self._by_name)
            raise fault(name.span, f"'{name.name}' is no template and no process.", todo)
        return self._by_name[name.name]

    def instantiate(self, name: ast.Name, scope: Scope) -> None:
        """Create the processes of a name on the ``system`` line: one, or one for each value of its free parameters."""
        definition = self._get(name)
        ranges = [self._free(definition, parameter, name) for parameter in definition.parameters]
        count = len(self.processes) + prod(max(0, each.stop - each.start) for each in ranges)
        if count > PROCESSES:  # before any of them is made
            raise fault(name.span, f"With '{name.name}' there are {count} processes, more than {PROCESSES}.")
        for values in product(*ranges):
            arguments = [ast.Number(name.span, value) for value in values]
            suffix = f"({','.join(map(str, values))})" if values else ""
            index = len(self.processes)
            process = self._process(definition, arguments, scope, name.name + suffix, index, self.places)
            self.processes.append(process)

    def _free(self, definition: _Definition, parameter: ast.Parameter, name: ast.Name) -> range:
        bounded = parameter.type.base != "int" or parameter.type.low is not None
        if parameter.reference or parameter.declarator.dimensions or not bounded:
            what = f"The parameter '{parameter.declarator.name}' of '{name.name}' has no value."
            raise fault(name.span, what, "Only a bounded integer may stay free on the system line.")
        low, high = Expressions(self.code, definition.scope).bounds(parameter.type)
        return range(low, high + 1)

    def _process(
        self,
        definition: _Definition,
        arguments: Iterable[ast.Expression],
        caller: Scope,
        name: str,
        index: int,
        places: Places,
    ) -> Process:
        scope = Scope(definition.scope)
        for parameter, argument in zip(definition.parameters, arguments, strict=True):
            _bind(self.code, parameter, argument, caller, scope)
        if definition.template:
            return make_process(self.code, places, definition.template, scope, name, index)
        node = definition.instantiation
        assert node is not None
        return self._process(self._get(node.template), node.arguments, scope, name, index, places)

    def check_unused(self) -> None:
        """Check templates without a process, if they have no parameters."""
        used = {process.template for process in self.processes}
        for definition in self._by_name.values():
            if definition.template and definition.name not in used and not definition.parameters:
                self._process(definition, (), definition.scope, definition.name, 0, Places())


def _bind(
    code: GeneratedCode, parameter: ast.Parameter, argument: ast.Expression, caller: Scope, scope: Scope
) -> None:
    """Declare a parameter in ``scope``: a constant for a value, or an alias for an argument passed by reference.

    Raises:
        ModelError: the argument is of another type, not constant, or out of range.
    """
    inner, outer = Expressions(code, scope), Expressions(code, caller)
    name = parameter.declarator.name
    type_ = resolve_dimensions(inner, resolve_type(inner, parameter.type), parameter.declarator)
    if parameter.reference:
        symbol = _reference(outer, argument, name, type_)
    elif not type_.integral:
        todo = f"Write '{type_.scalar} &{name}'."
        raise fault(parameter.span, f"The parameter '{name}' is a {type_.kind} by value.", todo)
    else:
        symbol = _constant(outer, argument, name, type_)
    scope.declare(name, symbol, parameter.span)


def _constant(outer: Expressions, argument: ast.Expression, name: str, type_: Type) -> Constant:
    values: tuple[int, ...]
    if not type_.single:
        term = outer.term(argument)
        if not isinstance(term, StorageTerm) or term.known is None or term.type.shape != type_.shape:
            raise fault(argument.span, f"'{argument.span.snippet}' is no constant {type_}.")
        values = term.known
    else:
        number = outer.constant(argument, f"The argument for '{name}'")
        values = (int(number != 0) if type_.kind == "bool" else number,)
    if not all(type_.low <= value <= type_.high for value in values):
        raise fault(argument.span, f"{name} = {argument.span.snippet} is out of its range {type_}.")
    return Constant(name, type_, values, "" if type_.single else outer.code.constant(values))


def _reference(outer: Expressions, argument: ast.Expression, name: str, expected: Type) -> Symbol:
    term = outer.term(argument)
    if not isinstance(term, StorageTerm | IndexedTerm) or term.computed or not _fits(term, expected):
        found = term.type if isinstance(term, StorageTerm | IndexedTerm) else "a number"
        raise fault(argument.span, f"'{argument.span.snippet}' is {found}.", f"'{name}' is {expected}.")
    if isinstance(term, IndexedTerm):
        kind = ClockSymbol if expected.kind == "clock" else ChannelSymbol
        declared = replace(term.type, broadcast=expected.broadcast, urgent=expected.urgent)
        return kind(term.name, declared, term.base + term.offset)
    if term.known is not None:
        if not expected.constant:
            raise fault(
                argument.span, f"'{argument.span.snippet}' is constant, but '{name}' may be assigned."
            )
        return Constant(name, expected, term.known, outer.code.constant(term.known))
    storage = term.storage
    assert isinstance(storage.base, int)  # outside of functions
    written = storage.written and not expected.constant
    return Storage(storage.name, term.type, "v", storage.base + term.offset, written)


def _fits(term: Term, expected: Type) -> bool:
    if not isinstance(term, StorageTerm | IndexedTerm):
        return False
    found = term.type
    if (found.kind, found.shape) != (expected.kind, expected.shape):
        return False
    if expected.kind == "chan":  # what may do more stands for what may do less, but not in an array
        have, need = (0 if each.urgent else 1 if each.broadcast else 2 for each in (found, expected))
        return have == need or (have > need and not expected.dimensions)
    return expected.constant or (found.low, found.high) == (expected.low, expected.high)
