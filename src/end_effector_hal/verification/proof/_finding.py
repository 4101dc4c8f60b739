"""Requirements, and the findings of a proof about them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial

from end_effector_hal.errors import ModelError
from timed_automata import Network, Trace
from timed_automata.check import checked_query
from timed_automata.queries import Query

_COMMENT = re.compile(r"\s*\[([a-z0-9][a-z0-9-]*)\]\s*(.*)", re.DOTALL)

UNMET = "does not apply here: its condition is never met"
"""Remark of a requirement that holds only because its condition never occurs."""


@dataclass(frozen=True, slots=True)
class WorstCase:
    """The longest time that a bounded response takes.

    Attributes:
        computed_ms: the supremum, ms; None: unknown, or the response never starts.
        declared_ms: the required bound, ms.
        at_least_ms: where the search for the supremum was ended, ms; None: the search was completed.
    """

    computed_ms: int | None
    declared_ms: int
    at_least_ms: int | None = None

    def __str__(self) -> str:
        if self.at_least_ms is not None:
            return f"at least {self.at_least_ms / 1000:g} s"
        return "never" if self.computed_ms is None else f"{self.computed_ms / 1000:g} s"

    def document(self) -> dict[str, float | None]:
        """Return the times in seconds; the key ``at_least`` exists only if the value itself is unknown."""
        found = {"computed": _seconds(self.computed_ms), "declared": _seconds(self.declared_ms)}
        return found if self.at_least_ms is None else {**found, "at_least": _seconds(self.at_least_ms)}


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer to one requirement.

    Attributes:
        id: id of the requirement.
        sentence: what must hold.
        query: empty for a check that no query can express.
        holds: whether it holds.
        states: symbolic states of the exploration that decided it.
        seconds: its share of the time of that exploration.
        remark: additional text: what was found, or that the requirement does not apply here.
        trace: the shortest run found that refutes it; None: there is none to show.
        worst: for ``A[] p imply x <= c``.
        decided: whether it was decided; an undecided one does not count as holding.
    """

    id: str
    sentence: str
    query: str
    holds: bool
    states: int
    seconds: float
    remark: str = ""
    trace: Trace | None = field(default=None, repr=False)
    worst: WorstCase | None = None
    decided: bool = True


@dataclass(frozen=True, slots=True)
class Requirement:
    """A sentence that must hold, with its query.

    Attributes:
        id: stable; from the comment ``[id] Sentence.``, or the number of the query.
        sentence: in words; the query itself if there is no sentence.
        query: as parsed.
    """

    id: str
    sentence: str
    query: Query = field(repr=False)

    @property
    def finding(self) -> Callable[..., Finding]:
        """A function that makes a finding about this requirement from the remaining fields."""
        return partial(Finding, self.id, self.sentence, str(self.query))


@lru_cache(maxsize=4)
def stored_requirements(network: Network) -> tuple[Requirement | Finding, ...]:
    """Return the requirements in the file of a network; an invalid query becomes an undecided finding with the reason.

    They are cached by the network: a report of many runs, and a page, need those of one tool again and again.

    Raises:
        ModelError: two queries have the same id.
    """
    found: dict[str, Requirement | Finding] = {}
    for number, stored in enumerate(network.document.queries, start=1):
        if not stored.formula.content.strip():
            continue
        named = _COMMENT.fullmatch(stored.comment)
        id_, sentence = (named[1], named[2]) if named else (f"query-{number}", stored.comment)
        if id_ in found:
            where = stored.formula.whole.where
            raise ModelError(f"Two queries are named [{id_}].", where=where, todo="Rename one of them.")
        said, asked = " ".join(sentence.split()), " ".join(stored.formula.content.split())
        try:
            found[id_] = Requirement(id_, said or asked, checked_query(network, stored))
        except ModelError as fault:
            remark = f"not decided: {fault}"
            found[id_] = Finding(id_, said or asked, asked, False, 0, 0.0, remark, decided=False)
    return tuple(found.values())


def requirements_of(network: Network) -> tuple[Requirement, ...]:
    """Return the requirements in the file of a network that can be checked; raises as `stored_requirements` does."""
    return tuple(each for each in stored_requirements(network) if isinstance(each, Requirement))


@dataclass(frozen=True, slots=True)
class Proof:
    """All findings about one network.

    Attributes:
        findings: one per requirement, in the order of the file, then the checks that no query expresses.
        states: symbolic states of the one exploration that most findings come from.
        seconds: total time.
        off: edges that cannot fire with these constants, but could with others.
        stopped: whether some findings are undecided because they took too much memory.
    """

    findings: tuple[Finding, ...]
    states: int
    seconds: float
    off: tuple[str, ...] = ()
    stopped: bool = False

    @property
    def holds(self) -> bool:
        """Whether every requirement holds."""
        return all(finding.holds for finding in self.findings)

    @property
    def bounds(self) -> dict[str, WorstCase]:
        """The worst cases by name; that of the requirement ``grip`` is ``grip_s``."""
        return {f"{f.id.replace('-', '_')}_s": f.worst for f in self.findings if f.worst is not None}

    def document(self, reasons: Mapping[str, str] | None = None) -> dict[str, object]:
        """Return the proof as JSON: requirements, bounds in seconds, and edges that are switched off.

        ``reasons``: by id, why requirements do not hold; default: the remark.
        """
        return {
            "requirements": [
                {
                    "id": finding.id,
                    "sentence": finding.sentence,
                    "query": finding.query,
                    "holds": finding.holds,
                    "states": finding.states,
                    "seconds": round(finding.seconds, 6),
                    "why": "" if finding.holds else (reasons or {}).get(finding.id, finding.remark),
                }
                for finding in self.findings
            ],
            "bounds": {name: worst.document() for name, worst in self.bounds.items()},
            "switched_off": list(self.off),
        }


def _seconds(ms: int | None) -> float | None:
    return None if ms is None else ms / 1000
