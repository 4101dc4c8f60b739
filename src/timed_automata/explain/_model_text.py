"""Collects all expressions of a file with the template that contains them, and the declarations of each template."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, NamedTuple

from timed_automata.document import Document, Text
from timed_automata.errors import ModelError
from timed_automata.language import (
    ast,
    parse_declarations,
    parse_expression,
    parse_parameters,
    parse_synchronisation,
    parse_updates,
)
from timed_automata.queries import parse_query

Key = tuple[str, str]
"""A declared name as the template that declares it (empty for the file) and the name."""


class Place(NamedTuple):
    """The place of an expression: a template (empty for the file) and the names that enclosing constructs bind."""

    template: str = ""
    bound: frozenset[str] = frozenset()


_LABELS: dict[str, Callable[[Text], Any]] = {
    "guard": parse_expression,
    "invariant": parse_expression,
    "synchronisation": parse_synchronisation,
    "assignment": parse_updates,
}


class ModelText:
    """The parsed texts of a document; texts that cannot be parsed are left out.

    Attributes:
        shared: the global declarations.
        functions: the global functions by name.
        parameters: names of the parameters, by template.
    """

    def __init__(self, document: Document) -> None:
        self.shared = _declared(document.declarations)
        self.functions = {each.name: each for each in self.shared if isinstance(each, ast.FunctionDefinition)}
        self._parts: list[tuple[str, object]] = [("", self.shared)]
        self._own: dict[str, set[str]] = {}
        self.parameters: dict[str, set[str]] = {}
        for template in document.templates:
            name, own = template.name.content.strip(), _declared(template.declarations)
            taken = [each for found in _parsed(parse_parameters, template.parameters) for each in found]
            self.parameters[name] = {each.declarator.name for each in taken}
            declared = {each.name for part in own for each in _declarators(part)}
            self._own[name] = declared | self.parameters[name]
            self._parts.append((name, own))
            labels = [each.labels for each in template.locations] + [each.labels for each in template.edges]
            for kind, label in (item for each in labels for item in each.items()):
                self._parts += ((name, part) for part in _parsed(_LABELS.get(kind), label.text))
        for query in document.queries:
            for parsed in _parsed(parse_query, query.formula):
                self._parts += (("", part) for part in (parsed.condition, parsed.then))

    def nodes(self) -> Iterator[tuple[Place, ast.Node]]:
        """Yield every node with its place."""
        for template, part in self._parts:
            yield from _nodes(part, Place(template))

    def key(self, place: Place, node: ast.Node) -> Key | None:
        """Return the declared name that an expression uses, without its index; None for other expressions."""
        while isinstance(node, ast.Index):
            node = node.base
        match node:
            case ast.Name(name=name) if name not in place.bound:
                return (place.template if name in self._own.get(place.template, ()) else "", name)
            case ast.Member(base=ast.Name(name=process) | ast.Call(name=process), name=name):
                return (process, name)
        return None


def _nodes(node: object, place: Place) -> Iterator[tuple[Place, ast.Node]]:
    if isinstance(node, tuple):
        for each in node:
            yield from _nodes(each, place)
    elif isinstance(node, ast.Node):
        place = place._replace(bound=place.bound | _bound_by(node))
        yield place, node
        for name in node.__dataclass_fields__:
            yield from _nodes(getattr(node, name), place)


def _bound_by(node: ast.Node) -> set[str]:
    match node:
        case ast.Quantified(variable=name) | ast.Iterate(variable=name):
            return {name}
        case ast.FunctionDefinition(parameters=parameters):
            return {each.declarator.name for each in parameters}
        case ast.Block(declarations=declarations):
            return {each.name for part in declarations for each in _declarators(part)}
    return set()


def _declared(text: Text | None) -> tuple[ast.Declaration, ...]:
    found: tuple[ast.Declaration, ...] = ()
    for each in _parsed(parse_declarations, text):
        found = each
    return found


def _parsed(parse: Callable[[Text], Any] | None, text: Text | None) -> Iterator[Any]:
    with suppress(ModelError):
        if parse is not None and text is not None and text.content.strip():
            yield parse(text)


def _declarators(part: ast.Declaration) -> tuple[ast.Declarator, ...]:
    return () if isinstance(part, ast.FunctionDefinition) else part.declarators
