"""Names for the integers of a model: constants, and the members that array indices refer to.

A model contains ``ee == GRIPPED``: then 3 is called GRIPPED if it is a value of ``ee``, and the other constants
declared together with GRIPPED name the other values, unless ``ee`` is also compared with constants of another group.
The comparisons come from all expressions of the file.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
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
from timed_automata.network import Network
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


_INDEX = re.compile(r"(?<=[\[(])\d+")
_EQUAL = ("==", "!=")


class Names:
    """Names for values and elements of a network.

    Args:
        network: a loaded network.
        members: names for the indices of the array ``like`` and of arrays declared with the same size.
        like: an array; every variable that indexes it has members as its values.
        also: further variables whose values are members.
    """

    def __init__(
        self, network: Network, members: Sequence[str] = (), like: str = "", also: Collection[str] = ()
    ) -> None:
        self.text = ModelText(network.document)
        self._network, self._members = network, tuple(members)
        self._groups = list(_groups(self.text, network))
        self._known = {name for group in self._groups for name in group}
        self._used: dict[Key, dict[str, None]] = defaultdict(dict)
        for place, node in self.text.nodes():
            for target, value in _equated(node):
                if (key := self.text.key(place, target)) is not None:
                    for name in self._constants(value):
                        self._used[key][name] = None
        self._arrays: set[Key] = set()
        if members:
            self._arrays = self._alike(like)
        indices = self._indices()
        self._chosen = {("", name) for name in also} | indices
        self._templates = {
            template
            for template, names in self.text.parameters.items()
            if {(template, n) for n in names} & indices
        }

    def value(self, variable: str, value: int) -> str:
        """Return the name of a value of a variable (``ee``, ``Gripper.i``, ``evidence[1]``), else the number."""
        if variable in self._network.offsets:
            type_ = self._network.variable(self._network.offsets[variable]).type
            if type_.kind == "bool":
                return "true" if value else "false"
        key = _key_of(variable)
        if key in self._chosen and 0 <= value < len(self._members):
            return f"{self._members[value]} ({value})"
        used = self._used.get(key, {})
        for name in used:
            if self._network.constants[name] == value:
                return name
        groups = [group for group in self._groups if used.keys() & group.keys()]
        if len(groups) == 1:  # of several, any could name what the file itself never compares
            for name, number in groups[0].items():
                if number == value:
                    return name
        return str(value)

    def element(self, name: str) -> str:
        """Return ``evidence[0]``, ``Actuator(0)`` and similar names with the member's name in place of the number."""
        process, dot, rest = name.rpartition(".")
        if process.partition("(")[0] in self._templates:
            process = self._named(process)
        key = _key_of(name)
        rest = self._named(rest) if key in self._arrays else rest
        if not dot and rest.partition("(")[0] in self._templates:
            rest = self._named(rest)
        return process + dot + rest

    def _named(self, name: str) -> str:
        def member(found: re.Match[str]) -> str:
            number = int(found[0])
            return self._members[number] if number < len(self._members) else found[0]

        return _INDEX.sub(member, name, count=1)

    def _constants(self, node: ast.Expression) -> Iterator[str]:
        match node:
            case ast.Name(name=name) if name in self._known:
                yield name
            case ast.Conditional(yes=yes, no=no):
                yield from self._constants(yes)
                yield from self._constants(no)

    def _alike(self, like: str) -> set[Key]:
        """Return the arrays declared with the same size as ``like``, except those whose own values index
        such arrays.
        """
        sizes: dict[Key, str] = {}
        for place, node in self.text.nodes():
            if isinstance(node, ast.Declarator) and node.dimensions:
                key = self.text.key(place, ast.Name(node.span, node.name))
                if key is not None:
                    sizes[key] = node.dimensions[0].span.snippet
        size = sizes.get(("", like))
        self._arrays = {key for key, written in sizes.items() if size is not None and written == size}
        return self._arrays - {key for key in self._indices() if key in sizes}

    def _indices(self) -> set[Key]:
        """Return the names that index one of these arrays."""
        found = (
            self.text.key(place, node.index)
            for place, node in self.text.nodes()
            if isinstance(node, ast.Index) and self.text.key(place, node.base) in self._arrays
        )
        return {key for key in found if key is not None}


def _key_of(variable: str) -> Key:
    process, _, name = variable.rpartition(".")
    return process.partition("(")[0], name.partition("[")[0]


def _groups(text: ModelText, network: Network) -> Iterator[dict[str, int]]:
    """Yield groups of constants declared together; a group has at least two, and only numbers."""
    for part in text.shared:
        if isinstance(part, ast.Variables) and "const" in part.type.prefixes and len(part.declarators) > 1:
            values = {each.name: network.constants.get(each.name) for each in part.declarators}
            numbers = {name: value for name, value in values.items() if isinstance(value, int)}
            if len(numbers) > 1:
                yield numbers


def _equated(node: ast.Node) -> Iterator[tuple[ast.Expression, ast.Expression]]:
    """Yield pairs of expressions that are compared or assigned to each other."""
    match node:
        case ast.Binary(left=left, op=op, right=right) if op in _EQUAL:
            yield left, right
            yield right, left
        case ast.Assignment(target=target, op="=", value=value):
            yield target, value
        case ast.Declarator(name=name, initialiser=initialiser) if initialiser is not None:
            yield ast.Name(node.span, name), initialiser
