"""Functions that summarize the verdicts on mutants, as a record and as the text of its file."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict

from end_effector_hal.verification.mutation import EdgeNeeds, MutationRecord, edge_key
from timed_automata.document import Document

from ._judge import MutantOutcome, MutantVerdict


def mutation_record(
    document: Document, verdicts: Iterable[MutantVerdict], *, of: int, seed: int | None
) -> MutationRecord:
    """Summarize the verdicts on mutants of a document.

    Args:
        document: the document that was edited.
        verdicts: the verdicts on its mutants.
        of: the number of all its mutants.
        seed: the seed by which the judged mutants were drawn, if they were.
    """
    templates = {each.name.content.strip(): each for each in document.templates}
    outcomes: dict[str, Counter[str]] = {}
    edits: Counter[str] = Counter()
    needed: dict[str, Counter[str]] = {}
    survivors = []
    for verdict in verdicts:
        mutant, outcome = verdict.mutant, verdict.outcome
        outcomes.setdefault(mutant.operator, Counter())[str(outcome)] += 1
        if outcome == MutantOutcome.SURVIVES:
            survivors.append(str(mutant))
        if mutant.edge is not None and outcome not in (MutantOutcome.INVALID, MutantOutcome.OFF):
            template = templates[mutant.template]
            key = edge_key(template, template.edges[mutant.edge])
            edits[key] += 1
            needed.setdefault(key, Counter()).update(verdict.caught_by)
    edges = {key: EdgeNeeds(edits[key], dict(needed[key].most_common())) for key in sorted(edits)}
    kinds = {kind: dict(sorted(counts.items())) for kind, counts in sorted(outcomes.items())}
    return MutationRecord(
        sum(sum(each.values()) for each in kinds.values()), of, seed, kinds, tuple(sorted(survivors)), edges
    )


def document_of(record: MutationRecord) -> dict[str, object]:
    """Return a record as JSON."""
    return {**asdict(record), "edges": {key: each._asdict() for key, each in record.edges.items()}}


def text_of(record: MutationRecord) -> str:
    """Return the text of its file: a line for each kind of edit, each survivor and each edge."""
    parts = []
    for name, value in document_of(record).items():
        lines: list[str] = []
        if isinstance(value, dict):
            lines = [f"{_json(key)}: {_json(each)}" for key, each in value.items()]
        elif isinstance(value, list):
            lines = [_json(each) for each in value]
        opened, closed = "{}" if isinstance(value, dict) else "[]"
        parts.append(
            f"{_json(name)}: "
            + (
                ",\n  ".join([f"{opened}\n  {lines[0]}", *lines[1:]]) + f"\n {closed}"
                if lines
                else _json(value)
            )
        )
    return "{\n " + ",\n ".join(parts) + "\n}\n"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
