"""What a proof says."""

from __future__ import annotations

from dataclasses import dataclass, field

from timed_automata import Trace


@dataclass(frozen=True, slots=True)
class WorstCase:
    """The longest time that a bounded response takes.

    Attributes:
        computed_ms: the supremum; None: not known, or it never starts.
        declared_ms: the bound that is required.
        at_least_ms: where the search for the supremum ended; None: it did not end before its time.
    """

    computed_ms: int | None
    declared_ms: int
    at_least_ms: int | None = None

    def __str__(self) -> str:
        if self.at_least_ms is not None:
            return f"at least {self.at_least_ms / 1000:g} s"
        return "never" if self.computed_ms is None else f"{self.computed_ms / 1000:g} s"

    def document(self) -> dict[str, float | None]:
        """In seconds; ``at_least`` only where the value itself is not known."""
        found = {"computed": _seconds(self.computed_ms), "declared": _seconds(self.declared_ms)}
        return found if self.at_least_ms is None else {**found, "at_least": _seconds(self.at_least_ms)}


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer to one requirement.

    Attributes:
        id: of the requirement.
        sentence: what must hold.
        query: empty for what no query can say.
        holds: whether it does.
        states: symbolic states of the exploration that decided it.
        seconds: its share of the time of that exploration.
        remark: what else is to be said: what was found, or that the requirement says nothing here.
        trace: the shortest run found that shows why not; None where there is none to show.
        worst: for ``A[] p imply x <= c``.
        decided: whether it was looked at; what was not does not hold either.
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
class Proof:
    """All findings about one network.

    Attributes:
        findings: a requirement each, in the order of the file, then what no query says.
        states: symbolic states of the one exploration that most of them come from.
        seconds: in all.
        off: edges that cannot fire with these constants, and could with others.
    """

    findings: tuple[Finding, ...]
    states: int
    seconds: float
    off: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether every requirement does."""
        return all(finding.holds for finding in self.findings)

    @property
    def bounds(self) -> dict[str, WorstCase]:
        """The worst cases by name: ``grip_s`` of the requirement ``grip``."""
        return {f"{f.id.replace('-', '_')}_s": f.worst for f in self.findings if f.worst is not None}

    def document(self) -> dict[str, object]:
        """As JSON: requirements, bounds in seconds, and edges that are switched off."""
        return {
            "requirements": [
                {
                    "id": finding.id,
                    "sentence": finding.sentence,
                    "query": finding.query,
                    "holds": finding.holds,
                    "states": finding.states,
                    "seconds": round(finding.seconds, 6),
                }
                for finding in self.findings
            ],
            "bounds": {name: worst.document() for name, worst in self.bounds.items()},
            "switched_off": list(self.off),
        }


def _seconds(ms: int | None) -> float | None:
    return None if ms is None else ms / 1000
