"""Parses templates once, and makes processes from them, with compiled locations and edges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import takewhile
from typing import Literal

from timed_automata._limits import PARTS, SELECTED
from timed_automata.compiler import (
    Condition,
    Effects,
    Expressions,
    GeneratedCode,
    IndexedTerm,
    Quantity,
    Scope,
    Updates,
    compile_condition,
    number_of,
)
from timed_automata.document import DrawnEdge, DrawnLocation, Span, Template, fault, refused
from timed_automata.language import (
    ast,
    parse_declarations,
    parse_expression,
    parse_name,
    parse_parameters,
    parse_selects,
    parse_synchronisation,
    parse_updates,
)
from timed_automata.network._declarations import Declarations, Places
from timed_automata.network._network import Edge, Location, Process, Update

Synchronised = tuple[Quantity | None, range, Literal["", "!", "?"]]


@dataclass(frozen=True, slots=True, eq=False)
class ParsedEdge:
    """An edge with parsed labels; source and target are numbers of locations."""

    drawn: DrawnEdge
    source: int
    target: int
    selects: tuple[ast.Select, ...]
    guard: ast.Expression | None
    synchronisation: ast.Synchronisation | None
    updates: tuple[ast.Expression, ...]


class ParsedTemplate:
    """A template with parsed texts.

    Raises:
        ModelError: a text is not well-formed, or two locations have the same name.
    """

    def __init__(self, template: Template) -> None:
        self.template = template
        self.name = parse_name(template.name)
        self.parameters = parse_parameters(template.parameters) if template.parameters else ()
        self.declarations = parse_declarations(template.declarations) if template.declarations else ()
        self._numbers = {location.id: number for number, location in enumerate(template.locations)}
        self.initial = self._numbers[template.initial]
        self.location_names = self._names()
        self.edges = tuple(parse_edge(edge, self._numbers) for edge in template.edges)

    def _names(self) -> tuple[str, ...]:
        """Return the names of the locations; a location without a name is called by its id."""
        names: dict[str, None] = {}
        for location in self.template.locations:
            name = parse_name(location.name.text) if location.name else location.id
            if name in names:
                place = location.name.text.whole if location.name else location.place.whole
                raise fault(place, f"Two locations of '{self.name}' are called '{name}'.")
            names[name] = None
        return tuple(names)


def parse_edge(edge: DrawnEdge, numbers: Mapping[str, int]) -> ParsedEdge:
    """Parse an edge of a template; ``numbers`` are the numbers of its locations by id."""
    labels = {kind: label.text for kind, label in edge.labels.items()}
    sync = labels.get("synchronisation")
    parsed = ParsedEdge(
        drawn=edge,
        source=numbers[edge.source],
        target=numbers[edge.target],
        selects=parse_selects(labels["select"]) if "select" in labels else (),
        guard=parse_expression(labels["guard"]) if "guard" in labels else None,
        synchronisation=parse_synchronisation(sync) if sync else None,
        updates=parse_updates(labels["assignment"]) if "assignment" in labels else (),
    )
    read = {"guard": parsed.guard, "synchronisation": parsed.synchronisation, "assignment": parsed.updates}
    before = takewhile(lambda kind: kind != "select", labels) if parsed.selects else ()
    early = [each for kind in before for each in ast.walk(read.get(kind))]
    bound = {getattr(each, "variable", "") for each in early}
    for each in early:
        if isinstance(each, ast.Name) and each.name in {select.name for select in parsed.selects} - bound:
            what = f"'{each.name}' is used here, but the label that selects it comes after this one."
            raise fault(each.span, what, "UPPAAL reads them in order: put the select label first.")
    return parsed


def make_process(
    code: GeneratedCode, places: Places, parsed: ParsedTemplate, scope: Scope, name: str, index: int
) -> Process:
    """Make a process from a template whose parameters are declared in ``scope``.

    Raises:
        ModelError: a text does not type-check, or is outside of the supported subset.
    """
    declarations = Declarations(code, places, scope, prefix=f"{name}.")
    for declaration in parsed.declarations:
        declarations.declare(declaration)
    _add_parts(code, len(parsed.location_names), parsed.template.name.whole)
    edges: list[Edge] = []
    for edge in parsed.edges:
        for each in make_edges(code, scope, edge, index, len(edges)):
            _add_parts(code, 1, edge.drawn.place.whole)
            edges.append(each)
    return Process(
        name=name,
        template=parsed.name,
        index=index,
        initial=parsed.initial,
        locations=tuple(
            make_location(Expressions(code, scope), drawn, parsed.location_names[number], number)
            for number, drawn in enumerate(parsed.template.locations)
        ),
        edges=tuple(edges),
        scope=scope,
    )


def _add_parts(code: GeneratedCode, count: int, span: Span) -> None:
    code.parts += count
    if code.parts > PARTS:
        what = f"More than {PARTS} locations and edges in all processes together."
        raise fault(span, what, "Take fewer processes, or select fewer values.")


def make_edges(
    code: GeneratedCode, scope: Scope, edge: ParsedEdge, process: int, first: int
) -> Iterator[Edge]:
    """Yield the edges of a process, one per combination of selected values, numbered from ``first`` on."""
    selections = _selections(Expressions(code, Scope(scope)), edge)
    for number, (expressions, selected) in enumerate(selections, start=first):
        yield _edge(expressions, edge, selected, process, number)


def make_location(expressions: Expressions, drawn: DrawnLocation, name: str, number: int) -> Location:
    """Make a location of a process."""
    label = drawn.labels.get("invariant")
    invariant = (
        compile_condition(expressions, parse_expression(label.text), "invariant") if label else Condition()
    )
    for constraint in invariant.clocks:
        if constraint.op == "==":
            what = f"'{constraint.span.snippet}', an invariant that is an equation with a clock"
            raise refused(constraint.span, what, "Expected a lower bound and an upper bound.")
    return Location(
        name=name,
        index=number,
        urgent=drawn.urgent,
        committed=drawn.committed,
        invariant=invariant,
        effects=expressions.effects,
        drawn=drawn,
    )


def _selections(expressions: Expressions, edge: ParsedEdge) -> Iterator[tuple[Expressions, dict[str, int]]]:
    """Yield expressions for every combination of selected values."""
    choices: list[tuple[Expressions, dict[str, int]]] = [(expressions, {})]
    for select in edge.selects:
        widened: list[tuple[Expressions, dict[str, int]]] = []
        for outer, selected in choices:
            low, high = outer.bounds(select.type)
            if len(choices) * (high - low + 1) > SELECTED:
                raise fault(select.span, f"More than {SELECTED} values are selected.")
            if select.name in selected:
                raise fault(select.span, f"'{select.name}' is declared twice.")
            widened += [
                (outer.binding(select.name, value), {**selected, select.name: value})
                for value in range(low, high + 1)
            ]
        choices = widened
    for inner, selected in choices:
        yield Expressions(inner.code, inner.scope, Effects()), selected


def _edge(
    expressions: Expressions, edge: ParsedEdge, selected: dict[str, int], process: int, number: int
) -> Edge:
    guard = compile_condition(expressions, edge.guard, "guard") if edge.guard else Condition()
    channel, channels, direction = _synchronisation(expressions, edge.synchronisation, guard)
    asks = frozenset(expressions.effects.reads)
    update, resets = _update(expressions, edge.updates)
    return Edge(
        process=process,
        index=number,
        source=edge.source,
        target=edge.target,
        guard=guard,
        direction=direction,
        channel=channel,
        channels=channels,
        update=update,
        resets=resets,
        selected=selected,
        asks=asks,
        effects=expressions.effects,
        drawn=edge.drawn,
        span=edge.drawn.place.whole,
    )


def _synchronisation(
    expressions: Expressions, node: ast.Synchronisation | None, guard: Condition
) -> Synchronised:
    if node is None:
        return None, range(0), ""
    channel = node.channel
    term = expressions.term(channel)
    if not isinstance(term, IndexedTerm) or term.type.kind != "chan":
        raise fault(channel.span, f"'{channel.span.snippet}' is no channel.")
    if term.type.dimensions:
        raise fault(channel.span, f"'{channel.span.snippet}' is an array of channels.", "Expected an index.")
    direction: Literal["!", "?"] = "!" if node.direction == "!" else "?"
    if guard.clocks and term.type.urgent:
        todo = "Guard the edge that leads to its source, or give the location an upper bound."
        raise refused(guard.clocks[0].span, "a clock guard on an edge with an urgent channel", todo)
    return number_of(expressions, term), term.possible, direction


def _update(
    expressions: Expressions, nodes: tuple[ast.Expression, ...]
) -> tuple[Update | None, frozenset[int]]:
    """Return the compiled update, and the clocks that it sets in every state."""
    if not nodes:
        return None, frozenset()
    updates = Updates(expressions)
    resets: set[int] = set()
    for node in nodes:
        updates.effect(node)
        if isinstance(node, ast.Assignment) and not ast.changed(node.target):
            term = Expressions(expressions.code, expressions.scope).term(node.target)
            if isinstance(term, IndexedTerm) and not term.computed:
                resets.add(term.possible.start)
    return expressions.code.procedure("v, r", updates.lines), frozenset(resets)
