"""The system section: what its names stand for, and the processes of the ``system`` line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from math import prod

from timed_automata._limits import PROCESSES
from timed_automata.compiler import Expressions, GeneratedCode, Scope
from timed_automata.document import did_you_mean, fault
from timed_automata.language import ast
from timed_automata.network._binding import bind
from timed_automata.network._instance import make_process
from timed_automata.network._network import Process
from timed_automata.network._places import Places
from timed_automata.network._templates import ParsedTemplate


@dataclass(frozen=True, slots=True, eq=False)
class _Definition:
    """A template, or a partial instantiation of another definition; ``scope``: where it is defined."""

    name: str
    parameters: tuple[ast.Parameter, ...]
    scope: Scope
    template: ParsedTemplate | None = None
    instantiation: ast.Instantiation | None = None


class Definitions:
    """Templates and their instantiations, by name; collects the ``processes`` that are made of them."""

    def __init__(self, code: GeneratedCode, places: Places) -> None:
        self.code, self.places = code, places
        self.processes: list[Process] = []
        self._by_name: dict[str, _Definition] = {}

    def add_template(self, parsed: ParsedTemplate, scope: Scope) -> None:
        """A template."""
        definition = _Definition(parsed.name, parsed.parameters, scope, template=parsed)
        self._add(definition, ast.Node(parsed.template.name.whole))

    def add_instantiation(self, node: ast.Instantiation, scope: Scope) -> None:
        """``name(parameters) = template(arguments);``"""
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
        """A name of the ``system`` line: one process, or one for each value of its free parameters."""
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
            bind(self.code, parameter, argument, caller, scope)
        if definition.template:
            return make_process(self.code, places, definition.template, scope, name, index)
        node = definition.instantiation
        assert node is not None
        return self._process(self._get(node.template), node.arguments, scope, name, index, places)

    def check_unused(self) -> None:
        """Templates without a process are checked all the same, if they can be made without arguments."""
        used = {process.template for process in self.processes}
        for definition in self._by_name.values():
            if definition.template and definition.name not in used and not definition.parameters:
                self._process(definition, (), definition.scope, definition.name, 0, Places())
