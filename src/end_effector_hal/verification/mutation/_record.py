"""What the judgement of many mutants has found, kept: the table by kinds of edit, and who needs which edge."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from end_effector_hal.errors import UsageError
from end_effector_hal.verification.mutation._judge import MutantOutcome, MutantVerdict
from timed_automata.document import Document, DrawnEdge, Template

KEPT_FILE = Path(__file__).with_name("kept.json")
"""The record of the shipped automata."""
CHECKS: Mapping[str, str] = {
    "ranges": "No assignment leaves the range of its variable, and no index its array.",
    "locations": "Every location can be reached.",
    "edges": "Every edge can fire.",
    "channels": "Every channel has both ends.",
    "room": "Every time-out that is executed is due D before its invariant ends it.",
    "time": "Time can always pass: no timelock, and no endless run in finite time.",
}
"""What notices a mutant and is no requirement of the file: sentences by id."""
_LABELS = ("select", "guard", "synchronisation", "assignment")
_SCHEMA = 1


class EdgeNeeds(NamedTuple):
    """What the edits of one edge have shown.

    Attributes:
        edits: how many were judged and are models, with the edge switched on.
        needed_by: how many of them each requirement, or check, has noticed, by its id; of one edit the first that
            fails is seen, with those that fail in the same exploration.
    """

    edits: int
    needed_by: Mapping[str, int]


@dataclass(frozen=True)
class MutationRecord:
    """The result of ``eehal model mutants``.

    Attributes:
        judged: how many mutants.
        of: how many there are.
        seed: of the sample; None: it is no sample that can be drawn again.
        outcomes: how many had which outcome, by the kind of edit.
        survivors: in words.
        edges: by template, ends and labels of an edge: one that was edited since is not in it.
    """

    judged: int
    of: int
    seed: int | None
    outcomes: Mapping[str, Mapping[str, int]]
    survivors: Sequence[str] = ()
    edges: Mapping[str, EdgeNeeds] = field(default_factory=dict, repr=False)

    def of_edge(self, template: Template, number: int) -> EdgeNeeds | None:
        """What was found of one of the edges of a template; None: nothing, or it is another edge by now."""
        return self.edges.get(_key(template, template.edges[number]))

    def text(self) -> str:
        """The text of its file: a line for each kind of edit, each survivor and each edge."""
        parts = []
        for name, value in self.document().items():
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

    def document(self) -> dict[str, object]:
        """As JSON has it."""
        return {
            "schema": _SCHEMA,
            "judged": self.judged,
            "of": self.of,
            "seed": self.seed,
            "outcomes": {kind: dict(counts) for kind, counts in self.outcomes.items()},
            "survivors": list(self.survivors),
            "edges": {
                key: {"edits": each.edits, "needed_by": dict(each.needed_by)}
                for key, each in self.edges.items()
            },
        }


def mutation_record(
    document: Document, verdicts: Iterable[MutantVerdict], *, of: int, seed: int | None
) -> MutationRecord:
    """Sum up the verdicts on mutants of a document.

    Args:
        document: that was edited.
        verdicts: on its mutants.
        of: how many mutants there are.
        seed: with which those that were judged were drawn, if they were.
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
            key = _key(template, template.edges[mutant.edge])
            edits[key] += 1
            needed.setdefault(key, Counter()).update(verdict.caught_by)
    edges = {key: EdgeNeeds(edits[key], dict(needed[key].most_common())) for key in sorted(edits)}
    kinds = {kind: dict(sorted(counts.items())) for kind, counts in sorted(outcomes.items())}
    return MutationRecord(
        sum(sum(each.values()) for each in kinds.values()), of, seed, kinds, tuple(sorted(survivors)), edges
    )


def read_record(text: str, where: str) -> MutationRecord:
    """A record from its JSON.

    Raises:
        UsageError: it is none.
    """
    try:
        given: Any = json.loads(text)
        if given["schema"] != _SCHEMA:
            raise ValueError(f"schema {given['schema']}")
        return MutationRecord(
            int(given["judged"]),
            int(given["of"]),
            None if given["seed"] is None else int(given["seed"]),
            {str(kind): _counts(counts) for kind, counts in given["outcomes"].items()},
            tuple(str(each) for each in given["survivors"]),
            {
                str(key): EdgeNeeds(int(each["edits"]), _counts(each["needed_by"]))
                for key, each in given["edges"].items()
            },
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(
            f"This is no record of judged mutants: {error}.",
            where=where,
            todo="Write one: eehal model mutants --record FILE.",
        ) from None


@cache
def kept_record() -> MutationRecord:
    """That of the shipped automata. Of automata with other edges it says what it knows of those that are the same."""
    return read_record(KEPT_FILE.read_text(encoding="utf-8"), str(KEPT_FILE))


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _counts(given: Mapping[Any, Any]) -> dict[str, int]:
    return {str(name): int(count) for name, count in given.items()}


def _key(template: Template, edge: DrawnEdge) -> str:
    """Template, ends and labels of an edge, in one line: where it is drawn does not matter."""
    names = {each.id: each.name.text.content.strip() if each.name else each.id for each in template.locations}
    labels = (edge.labels[kind].text.content for kind in _LABELS if kind in edge.labels)
    ends = f"{names[edge.source]} -> {names[edge.target]}"
    return " | ".join((template.name.content.strip(), ends, *(" ".join(each.split()) for each in labels)))
