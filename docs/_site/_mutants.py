"""What has become of the mutants of the shipped automata, and which requirement needs which edge."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from end_effector_hal.control import load_automata
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification.mutation import kept_record
from timed_automata.document import Template

from ._markdown import plain, table

HEADS = (
    "kind of edit", "proof", "load error", "equivalent", "switched off", "survives", "too many states",
)  # fmt: skip
_OUTCOMES = ("caught", "invalid", "equivalent", "off", "survives", "open")


def mutants() -> str:
    """The table by kinds of edit, the survivors, and the edges of each template."""
    record = kept_record()
    total: Counter[str] = Counter()
    for counts in record.outcomes.values():
        total.update(counts)
    rows = [(kind, *_cells(counts)) for kind, counts in record.outcomes.items()]
    parts = [
        "## By kinds of edit",
        f"{record.judged} of {record.of} mutants. `make mutants` judges all again, in a checkout.",
        table(HEADS, [*rows, ("all", *_cells(total))]),
    ]
    if record.survivors:
        parts.append("Survivors:")
        parts.append("\n".join(f"- {plain(each)}" for each in record.survivors))
    else:
        parts.append(
            "None survives."
            if record.judged == record.of
            else "Of these none survives; the others are not judged."
        )
    tool = load(profile_path())
    for template in load_automata(tool).document.templates:
        if template.name.content.strip() in tool.automata.executed:
            parts += _edges(template)
    return "\n\n".join(parts)


def _cells(counts: dict[str, int] | Counter[str]) -> Iterator[str]:
    return (str(counts.get(outcome, 0)) for outcome in _OUTCOMES)


def _edges(template: Template) -> Iterator[str]:
    record, name = kept_record(), template.name.content.strip()
    places = {each.id: each.name.text.content.strip() for each in template.locations if each.name}
    rows = []
    for number, edge in enumerate(template.edges):
        needs = record.of_edge(template, number)
        by = [f"`{id_}`" for id_ in needs.needed_by] if needs else []
        ends = f"{places.get(edge.source, edge.source)} → {places.get(edge.target, edge.target)}"
        rows.append((str(number + 1), ends, str(needs.edits if needs else 0), ", ".join(by)))
    yield f"## The edges of {name}"
    yield table(("", "edge", "edits judged", "needed by"), rows)
