"""What has become of the mutants of the shipped automata."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from end_effector_hal.verification.mutation import kept_record

from ._markdown import plain, table

HEADS = (
    "kind of edit", "proof", "load error", "equivalent", "switched off", "survives", "too many states",
)  # fmt: skip
_OUTCOMES = ("caught", "invalid", "equivalent", "off", "survives", "open")


def mutants() -> str:
    """The table by kinds of edit, and the survivors."""
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
    return "\n\n".join(parts)


def _cells(counts: dict[str, int] | Counter[str]) -> Iterator[str]:
    return (str(counts.get(outcome, 0)) for outcome in _OUTCOMES)
