"""The places where an edited network differs; in all other states it has the moves of the original."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

from timed_automata.document import Label, Template
from timed_automata.language import ast, names_in, parse_declarations
from timed_automata.network import Network, Process


class EditedPlaces(NamedTuple):
    """The locations of a process in which its behaviour may differ."""

    process: int
    locations: frozenset[int]


def edited_places(network: Network, edited: Network) -> tuple[EditedPlaces, ...] | None:
    """Return the places where a network and an edited one differ in edges, locations and functions.

    None: the rest also differs, so the difference may be anywhere.
    """
    ours, theirs = network.document, edited.document
    templates = {each.name.content.strip(): each for each in ours.templates}
    others = {each.name.content.strip(): each for each in theirs.templates}
    shared = replace(theirs, templates=ours.templates) == ours and templates.keys() == others.keys()
    if not shared or network.constants != edited.constants:
        return None
    functions = {name: _functions(each, others[name]) for name, each in templates.items()}
    found = []
    for one, other in zip(network.processes, edited.processes, strict=True):
        changed = functions[one.template]
        if changed is None:
            return None
        places = frozenset(chain(_differing(one, other, changed), _differing(other, one, changed)))
        if places:
            found.append(EditedPlaces(one.index, places))
    return tuple(found)


def _functions(template: Template, other: Template) -> Collection[str] | None:
    """Return the functions of a template that differ in another one; None: more than functions differs."""
    if (template.name, template.parameters) != (other.name, other.parameters):
        return None
    if template.declarations == other.declarations:
        return ()
    ours, theirs = _texts(template), _texts(other)
    if ours.keys() != theirs.keys():
        return None
    changed = {name for name, text in ours.items() if text != theirs[name]}
    if "" in changed:
        return None
    while more := {name for name, text in ours.items() if name not in changed and names_in(text) & changed}:
        if "" in more:
            return None
        changed |= more
    return changed


def _texts(template: Template) -> dict[str, str]:
    """Return the declaration of each function of a template by name; all other declarations have the name ""."""
    texts = {"": ""}
    for each in parse_declarations(template.declarations) if template.declarations else ():
        text = each.span.text.content[each.span.start : each.span.end]
        if isinstance(each, ast.FunctionDefinition):
            texts[each.name] = text
        else:
            texts[""] += text
    return texts


def _differing(process: Process, other: Process, functions: Collection[str]) -> Iterator[int]:
    """Yield the locations of a process that another one lacks or has with an edge missing or different."""
    locations, edges = ({id(each.drawn) for each in parts} for parts in (other.locations, other.edges))
    changed = {
        each.index
        for each in process.locations
        if id(each.drawn) not in locations or _calls(each.drawn.labels, functions)
    }
    yield from changed
    for edge in process.edges:
        if id(edge.drawn) not in edges or edge.target in changed or _calls(edge.drawn.labels, functions):
            yield edge.source


def _calls(labels: Mapping[str, Label], functions: Collection[str]) -> bool:
    return bool(functions) and any(
        not names_in(each.text.content).isdisjoint(functions) for each in labels.values()
    )
