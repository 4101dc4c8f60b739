"""A network that is made of another one, where only edges and locations were edited, is that of the edited document."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.unit.timed_automata.explore.models import network
from timed_automata import Document, Network, make_network
from timed_automata.errors import ModelError, RangeError
from timed_automata.explore.search import Search
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits
from timed_automata.network import remake_network
from tools.mutants import mutants


def small() -> Network:
    Light = """Light(const int[0, 1] id):
        own: clock u; int[0, 2] n; int worth(int of) { return of + id; }
        Lit: u <= 3 + id
        Off -> Lit; select: level : int[1, 2]; sync: go[id]?; do: n = level, u = 0
        Lit -> Off; guard: u >= 2 && worth(n) > 1; do: n = 0
        Lit -> Out; guard: u >= 3; sync: gone!"""
    World = "World: w -> w; select: i : int[0, 1]; guard: c >= 1; sync: go[i]!; do: c = 0"
    declarations = "clock c; broadcast chan go[2], gone;"
    return network(declarations, Light, World)


def reached(of: Network) -> object:
    """All discrete states, or the fault on the way."""
    space = SymbolicSpace(DiscreteSpace(of), Limits(of))
    try:
        return {node.record.discrete.state for node in Search(space).nodes()}
    except RangeError as error:
        return str(error)


def made(document: Document) -> Network | str:
    try:
        return make_network(document)
    except ModelError as error:
        return str(error)


def remade(model: Network, document: Document) -> Network | str | None:
    try:
        return remake_network(model, document)
    except ModelError as error:
        return str(error)


def test_it_does_what_the_network_of_the_edited_document_does() -> None:
    model = small()
    compared = 0
    for each in mutants(model.document):
        expected, found = made(each.document), remade(model, each.document)
        if found is None:
            assert each.element.startswith("function")
        elif isinstance(found, str) or isinstance(expected, str):
            assert found == expected, each
        else:
            assert reached(found) == reached(expected), each
            for one, other in zip(found.processes, expected.processes, strict=True):
                assert [edge.index for edge in one.edges] == list(range(len(other.edges)))
                assert [(edge.source, edge.target, edge.direction, edge.selected) for edge in one.edges] == [
                    (edge.source, edge.target, edge.direction, edge.selected) for edge in other.edges
                ]
            compared += 1
    assert compared > 50


def test_what_was_not_edited_is_not_compiled_again() -> None:
    model = small()
    each = next(each for each in mutants(model.document, ["World"]))
    found = remake_network(model, each.document)
    assert found.code is model.code
    assert found.document is each.document
    assert found.processes[0] is model.processes[0]
    assert found.processes[2] is not model.processes[2]


@pytest.mark.parametrize("edited", ["declarations", "parameters", "a location", "the start", "the system"])
def test_more_than_edges_and_kinds_of_locations_is_made_as_a_whole(edited: str) -> None:
    model, other = small(), small().document
    document, (light, world) = model.document, model.document.templates
    if edited == "a location":
        light = replace(light, locations=light.locations[:2])
    elif edited == "the start":
        light = replace(light, initial=light.locations[1].id)
    elif edited == "the system":
        document = replace(document, system=other.system)
    else:
        light = replace(light, **{edited: getattr(other.templates[0], edited)})
    assert remake_network(model, replace(document, templates=(light, world))) is None
