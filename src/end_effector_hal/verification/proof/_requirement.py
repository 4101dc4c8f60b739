"""A requirement: a query of the UPPAAL file and its sentence."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from end_effector_hal.errors import ModelError
from timed_automata import Network
from timed_automata.queries import Query, parse_query

_COMMENT = re.compile(r"\s*\[([a-z0-9][a-z0-9-]*)\]\s*(.*)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Requirement:
    """What must hold.

    Attributes:
        id: stable; from the comment ``[id] Sentence.``, or the number of the query.
        sentence: in words; the query itself if it has none.
        query: as parsed.
    """

    id: str
    sentence: str
    query: Query = field(repr=False)


def requirements_of(network: Network) -> tuple[Requirement, ...]:
    """The requirements that are stored in the file of a network.

    Raises:
        ModelError: a query is outside of the supported subset, or two have one id.
    """
    found: dict[str, Requirement] = {}
    for number, stored in enumerate(network.document.queries, start=1):
        if not stored.formula.content.strip():
            continue
        query = parse_query(stored.formula)
        named = _COMMENT.fullmatch(stored.comment)
        id_, sentence = (named[1], named[2]) if named else (f"query-{number}", stored.comment)
        if id_ in found:
            where = stored.formula.whole.where
            raise ModelError(f"Two queries are named [{id_}].", where=where, todo="Rename one of them.")
        found[id_] = Requirement(id_, " ".join(sentence.split()) or str(query), query)
    return tuple(found.values())
