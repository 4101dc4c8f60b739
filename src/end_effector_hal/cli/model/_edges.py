"""Print which requirements need each edge of a template, by the record of the judged mutants."""

from __future__ import annotations

from collections.abc import Iterator

from timed_automata.document import Template


def edge_needs(template: Template) -> list[dict[str, object]]:
    """For each edge, in the order of the file: its ends, how many edits were judged, and who has noticed how many."""
    from end_effector_hal.verification.mutation import kept_record

    names = {each.id: each.name.text.content.strip() if each.name else each.id for each in template.locations}
    found: list[dict[str, object]] = []
    for number, edge in enumerate(template.edges):
        needs = kept_record().of_edge(template, number)
        found.append({
            "edge": f"{names[edge.source]} -> {names[edge.target]}",
            "place": edge.place.where(0),
            "edits": needs.edits if needs else 0,
            "needed_by": dict(needs.needed_by) if needs else {},
        })  # fmt: skip
    return found


def told_edges(template: Template) -> Iterator[str]:
    """A line for each edge."""
    for number, each in enumerate(edge_needs(template), start=1):
        needed_by = each["needed_by"]
        assert isinstance(needed_by, dict)
        if not each["edits"]:
            yield f"  {number}. {each['edge']}: no edit of it was judged"
        else:
            by = ", ".join(needed_by) or "no requirement"
            yield f"  {number}. {each['edge']}: needed by {by} (edits judged: {each['edits']})"
