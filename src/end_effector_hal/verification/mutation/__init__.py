"""The stored record of the judged mutants of the shipped automata: which requirements need which edge."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from timed_automata.document import DrawnEdge, Template

KEPT_FILE = Path(__file__).with_name("kept.json")
"""The record of the shipped automata."""
_LABELS = ("select", "guard", "synchronisation", "assignment")


class EdgeNeeds(NamedTuple):
    """The judged edits of one edge.

    Attributes:
        edits: number of edits that were judged and are valid models, with the edge switched on.
        needed_by: number of edits that each requirement, or check, has detected, by its id; for one edit only the
            first failure is counted, with those that fail in the same exploration.
    """

    edits: int
    needed_by: Mapping[str, int]


@dataclass(frozen=True)
class MutationRecord:
    """The result of ``make mutants``.

    Attributes:
        judged: number of judged mutants.
        of: number of all mutants.
        seed: seed of the sample; None: the judged mutants are no sample that can be drawn again.
        outcomes: number of mutants by the kind of edit and the outcome.
        survivors: the surviving mutants in words.
        edges: by template, ends and labels of an edge: an edge that was edited since is not found.
    """

    judged: int
    of: int
    seed: int | None
    outcomes: Mapping[str, Mapping[str, int]]
    survivors: Sequence[str] = ()
    edges: Mapping[str, EdgeNeeds] = field(default_factory=dict, repr=False)

    def of_edge(self, template: Template, number: int) -> EdgeNeeds | None:
        """Return the judged edits of an edge of a template; None: there are none, or the edge was edited since."""
        return self.edges.get(edge_key(template, template.edges[number]))


@cache
def kept_record() -> MutationRecord:
    """Return the record of the shipped automata; for other automata it is valid for the edges that are the same."""
    given: Any = json.loads(KEPT_FILE.read_text(encoding="utf-8"))
    edges = {key: EdgeNeeds(each["edits"], each["needed_by"]) for key, each in given["edges"].items()}
    return MutationRecord(**{**given, "survivors": tuple(given["survivors"]), "edges": edges})


def edge_key(template: Template, edge: DrawnEdge) -> str:
    """Return the template, the ends and the labels of an edge in one line; its position in the drawing is ignored."""
    names = {each.id: each.name.text.content.strip() if each.name else each.id for each in template.locations}
    labels = (edge.labels[kind].text.content for kind in _LABELS if kind in edge.labels)
    ends = f"{names[edge.source]} -> {names[edge.target]}"
    return " | ".join((template.name.content.strip(), ends, *(" ".join(each.split()) for each in labels)))
