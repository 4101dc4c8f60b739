"""Yields all mutants of the templates of a file and of its global declarations, in the order of the file."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from timed_automata.document import (
    Document,
    DrawnEdge,
    DrawnLocation,
    Label,
    Span,
    Template,
    Text,
    did_you_mean,
)
from timed_automata.errors import UsageError
from timed_automata.language import (
    ast,
    parse_declarations,
    parse_expression,
    parse_synchronisation,
    parse_updates,
)

from ._text_edits import (
    TextEdit,
    in_declarator,
    in_function,
    in_guard,
    in_updates,
)


@dataclass(frozen=True, slots=True)
class Mutant:
    """A file with one edit.

    Attributes:
        operator: the kind of edit: ``comparison``, ``constant``, ``target``, …
        template: the name of the edited template; empty: the global declarations.
        element: the edited element, in words: ``Step -> Reset, guard``, ``invariant of Step``, ``function rest``.
        place: ``file:line:column``.
        old, new: the text before and after the edit.
        edge: the number of the edge within its template; None: not an edge.
        location: the id of the location; empty: not a location.
        document: the edited file; a network can be made of it, but it cannot be written to a file.
    """

    operator: str
    template: str
    element: str
    place: str
    old: str
    new: str
    edge: int | None
    location: str
    document: Document = field(repr=False)

    def __str__(self) -> str:
        return f"{self.template or 'global'}, {self.element}: {self.operator}, '{self.old}' -> '{self.new}'"


def mutants(
    document: Document, templates: Collection[str] | None = None, given: Collection[str] = ()
) -> Iterator[Mutant]:
    """Yield the mutants of the templates with these names (None: all templates); many are invalid models.

    First come mutants of the global functions and declarations that these templates use, and of functions that no
    template uses. Constants that are ``given`` from outside are not edited, since their values in the file are
    replaced.

    Raises:
        ModelError: a text is not well-formed.
        UsageError: a template name does not exist.
    """
    known = [template.name.content.strip() for template in document.templates]
    for name in templates or ():
        if name not in known:
            raise UsageError(f"{document.path} has no template '{name}'.", todo=did_you_mean(name, known))
    yield from _OfDeclarations(document, known if templates is None else templates, given).mutants()
    for number, name in enumerate(known):
        if templates is None or name in templates:
            yield from _OfTemplate(document, number, name).mutants()


class Edited(NamedTuple):
    """The place of an edit, and the text before and after it."""

    place: str
    old: str
    new: str


class _OfDeclarations:
    """The mutants of the global declarations that some templates use."""

    def __init__(self, document: Document, templates: Collection[str], given: Collection[str]) -> None:
        self.document, self.given = document, given
        text = document.declarations
        self.declared = list(parse_declarations(text)) if text else []
        functions = {each.name: each for each in self.declared if isinstance(each, ast.FunctionDefinition)}
        of = {each.name.content.strip(): _words(each) for each in document.templates}
        self.used = set().union(*(of[name] for name in templates))
        calling = set().union(*of.values())
        called = {name for each in functions.values() for name in _names(each.body)}
        self.alone = functions.keys() - calling - called  # only queries, or a program, ask them
        self.used |= self.alone
        for function in reversed(functions.values()):  # what a function calls is declared before it
            if function.name in self.used:
                self.used |= _names(function.body)

    def mutants(self) -> Iterator[Mutant]:
        for each in self.declared:
            if isinstance(each, ast.FunctionDefinition) and each.name in self.used:
                who = ", which no template calls" if each.name in self.alone else ""
                yield from self._made(f"function {each.name}{who}", in_function(each))
            elif isinstance(each, ast.Variables) and each.type.base not in ("clock", "chan"):
                for one in each.declarators:
                    if one.name in self.used and one.name not in self.given:
                        yield from self._made(
                            f"declaration of {one.name}", in_declarator(one, boolean=each.type.base == "bool")
                        )

    def _made(self, element: str, edits: Iterator[TextEdit]) -> Iterator[Mutant]:
        for edit in edits:
            document = replace(self.document, declarations=edit.applied())
            yield Mutant(edit.operator, "", element, *_edited(edit), None, "", document)


class _OfTemplate:
    def __init__(self, document: Document, number: int, name: str) -> None:
        self.document, self.number, self.name = document, number, name
        self.template = document.templates[number]
        declared = (document.declarations, self.template.declarations)
        self.functions = {
            each.name: each
            for text in declared
            for each in (parse_declarations(text) if text else ())
            if isinstance(each, ast.FunctionDefinition)
        }
        self.names = {location.id: _name(location) for location in self.template.locations}

    def mutants(self) -> Iterator[Mutant]:
        yield from self._of_functions()
        for number, location in enumerate(self.template.locations):
            yield from self._of_location(number, location)
        for number, edge in enumerate(self.template.edges):
            yield from self._of_edge(number, edge)

    def _mutant(
        self,
        operator: str,
        element: str,
        where: Edited,
        edited: Template,
        edge: int | None = None,
        location: str = "",
    ) -> Mutant:
        templates = list(self.document.templates)
        templates[self.number] = edited
        document = replace(self.document, templates=tuple(templates))
        return Mutant(operator, self.name, element, *where, edge, location, document)

    def _of_functions(self) -> Iterator[Mutant]:
        text = self.template.declarations
        for declaration in parse_declarations(text) if text else ():
            if isinstance(declaration, ast.FunctionDefinition):
                element = f"function {declaration.name}"
                for edit in in_function(declaration):
                    edited = replace(self.template, declarations=edit.applied())
                    yield self._mutant(edit.operator, element, _edited(edit), edited)

    # Locations

    def _of_location(self, number: int, location: DrawnLocation) -> Iterator[Mutant]:
        def made(operator: str, element: str, where: Edited, drawn: DrawnLocation) -> Mutant:
            locations = list(self.template.locations)
            locations[number] = drawn
            edited = replace(self.template, locations=tuple(locations))
            return self._mutant(operator, element, where, edited, location=location.id)

        name = self.names[location.id]
        if "invariant" in location.labels:
            for edit in in_guard(parse_expression(location.labels["invariant"].text)):
                labels = _with(location.labels, "invariant", edit)
                yield made(
                    edit.operator, f"invariant of {name}", _edited(edit), replace(location, labels=labels)
                )
        now = "committed" if location.committed else "urgent" if location.urgent else "ordinary"
        for kind in ("committed", "urgent", "ordinary"):
            if kind != now:
                where = Edited(location.place.where(0), now, kind)
                drawn = replace(location, committed=kind == "committed", urgent=kind == "urgent")
                yield made(kind, f"location {name}", where, drawn)

    # Edges

    def _of_edge(self, number: int, edge: DrawnEdge) -> Iterator[Mutant]:
        source, target = self.names[edge.source], self.names[edge.target]
        element, place = f"{source} -> {target}", edge.place.where(0)

        def made(operator: str, part: str, where: Edited, drawn: DrawnEdge | None) -> Mutant:
            edges = list(self.template.edges)
            edges[number : number + 1] = [drawn] if drawn else []
            edited = replace(self.template, edges=tuple(edges))
            return self._mutant(operator, f"{element}, {part}" if part else element, where, edited, number)

        yield made("edge deleted", "", Edited(place, element, ""), None)
        for id_, name in self.names.items():
            if id_ != edge.target:
                where = Edited(place, element, f"{source} -> {name}")
                yield made("target", "", where, replace(edge, target=id_))
        for kind, edits in self._edits(edge):
            for edit in edits:
                labels = _with(edge.labels, kind, edit)
                yield made(edit.operator, kind, _edited(edit), replace(edge, labels=labels))

    def _edits(self, edge: DrawnEdge) -> Iterator[tuple[str, Iterator[TextEdit]]]:
        texts = {kind: label.text for kind, label in edge.labels.items()}
        if "guard" in texts:
            yield "guard", in_guard(parse_expression(texts["guard"]))
        if "synchronisation" in texts:
            yield "synchronisation", self._synchronisations(texts["synchronisation"])
        if "assignment" in texts:
            yield "assignment", in_updates(parse_updates(texts["assignment"]), self.functions)

    def _synchronisations(self, text: Text) -> Iterator[TextEdit]:
        here = parse_synchronisation(text)
        yield TextEdit("synchronisation", text.whole, "")
        content = text.content.strip()
        turned = content[:-1] + {"!": "?", "?": "!"}[here.direction]
        yield TextEdit("synchronisation", text.whole, turned)
        for other in self._channels(here):
            yield TextEdit("synchronisation", _name_of(here.channel), other)

    def _channels(self, here: ast.Synchronisation) -> Iterator[str]:
        """Yield other channels with as many indices that this template uses in the same direction."""
        seen = {_source(_name_of(here.channel))}
        for edge in self.template.edges:
            if label := edge.labels.get("synchronisation"):
                other = parse_synchronisation(label.text)
                name = _source(_name_of(other.channel))
                alike = other.direction == here.direction and _depth(other.channel) == _depth(here.channel)
                if alike and name not in seen:
                    seen.add(name)
                    yield name


def _words(template: Template) -> set[str]:
    """Return all names in the texts of a template."""
    labels = [*(each.labels for each in template.locations), *(each.labels for each in template.edges)]
    texts = [label.text for each in labels for kind, label in each.items() if kind != "comments"]
    code = [template.declarations] if template.declarations else []
    return {word for text in (*texts, *code) for word in re.findall(r"[A-Za-z_]\w*", text.content)}


def _names(node: ast.Node) -> set[str]:
    """Return the names in a part of a text, including functions that it calls."""
    found = {each.name for each in ast.walk(node) if isinstance(each, ast.Name | ast.Call)}
    return {str(name) for name in found}


def _edited(edit: TextEdit) -> Edited:
    return Edited(edit.span.where, edit.span.snippet, " ".join(edit.new.split()))


def _name(location: DrawnLocation) -> str:
    return location.name.text.content.strip() if location.name else location.id


def _with(labels: Mapping[str, Label], kind: str, edit: TextEdit) -> dict[str, Label]:
    """Return the labels with one edited; a label that becomes empty is removed."""
    text = edit.applied()
    rest = {name: label for name, label in labels.items() if name != kind}
    return rest | {kind: replace(labels[kind], text=text)} if text.content.strip() else rest


def _name_of(channel: ast.Expression) -> Span:
    while isinstance(channel, ast.Index):
        channel = channel.base
    return channel.span


def _depth(channel: ast.Expression) -> int:
    return 1 + _depth(channel.base) if isinstance(channel, ast.Index) else 0


def _source(span: Span) -> str:
    return span.text.content[span.start : span.end]
