"""Templates with their texts parsed, once for all processes made of them."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata.document import DrawnEdge, Template, fault
from timed_automata.language import (
    ast,
    parse_declarations,
    parse_expression,
    parse_parameters,
    parse_selects,
    parse_synchronisation,
    parse_updates,
)


@dataclass(frozen=True, slots=True, eq=False)
class ParsedEdge:
    """An edge with its labels parsed; source and target by number."""

    drawn: DrawnEdge
    source: int
    target: int
    selects: tuple[ast.Select, ...]
    guard: ast.Expression | None
    synchronisation: ast.Synchronisation | None
    updates: tuple[ast.Expression, ...]


class ParsedTemplate:
    """A template with its texts parsed.

    Raises:
        ModelError: a text is not well-formed, or two locations have one name.
    """

    def __init__(self, template: Template) -> None:
        self.template = template
        self.name = template.name.content.strip()
        self.parameters = parse_parameters(template.parameters) if template.parameters else ()
        self.declarations = parse_declarations(template.declarations) if template.declarations else ()
        self._numbers = {location.id: number for number, location in enumerate(template.locations)}
        self.initial = self._numbers[template.initial]
        self.location_names = self._names()
        self.invariants = [
            parse_expression(location.labels["invariant"].text) if "invariant" in location.labels else None
            for location in template.locations
        ]
        self.edges = tuple(map(self._edge, template.edges))

    def _names(self) -> tuple[str, ...]:
        """The id stands for the name of a location that has none."""
        names: dict[str, None] = {}
        for location in self.template.locations:
            name = location.name.text.content.strip() if location.name else location.id
            if name in names:
                place = location.name.text.whole if location.name else location.place.whole
                raise fault(place, f"Two locations of '{self.name}' are called '{name}'.")
            names[name] = None
        return tuple(names)

    def _edge(self, edge: DrawnEdge) -> ParsedEdge:
        labels = {kind: label.text for kind, label in edge.labels.items()}
        sync = labels.get("synchronisation")
        return ParsedEdge(
            drawn=edge,
            source=self._numbers[edge.source],
            target=self._numbers[edge.target],
            selects=parse_selects(labels["select"]) if "select" in labels else (),
            guard=parse_expression(labels["guard"]) if "guard" in labels else None,
            synchronisation=parse_synchronisation(sync) if sync else None,
            updates=parse_updates(labels["assignment"]) if "assignment" in labels else (),
        )
