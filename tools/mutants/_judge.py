"""The judgement of one mutant: the requirement, or check of every model, that it violates."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

from end_effector_hal.errors import ModelError, RangeError, UsageError
from end_effector_hal.verification.proof import Requirement, requirements_of
from timed_automata import Network, make_network
from timed_automata.explore import Explorer, Overview, ReactionBound, overview
from timed_automata.explore.properties import Coverage
from timed_automata.network import Given

from ._edits import Mutant
from ._equivalence import ReachedNetwork

_MORE = 10  # times the states of the file as it is; a mutant that has more is not searched further
_FEW = 100  # pairs of states that differ: so many are compared before the requirements are asked


class MutantOutcome(StrEnum):
    """The outcome of judging a mutant."""

    CAUGHT = "caught"
    EQUIVALENT = "equivalent"  # proven to do the same as the file as it is: there is nothing to notice
    SURVIVES = "survives"
    INVALID = "invalid"  # no model any more: the compiler refuses it
    OFF = "off"  # of an edge that the constants of every tool switch off: nothing to be noticed
    OPEN = "open"  # too many states


@dataclass(frozen=True, slots=True)
class MutantVerdict:
    """A mutant and its outcome.

    Attributes:
        mutant: the mutant.
        outcome: the outcome.
        caught_by: ids of violated requirements or checks; the search ends at the first.
        variant: the name of the tool that caught it; empty: the tool at hand.
    """

    mutant: Mutant
    outcome: MutantOutcome
    caught_by: tuple[str, ...] = ()
    variant: str = ""

    def document(self) -> dict[str, object]:
        """The verdict as JSON."""
        one = self.mutant
        return {
            "template": one.template,
            "element": one.element,
            "operator": one.operator,
            "old": one.old,
            "new": one.new,
            "place": one.place,
            "outcome": str(self.outcome),
            "caught_by": list(self.caught_by),
            "variant": self.variant,
        }


class _Found(NamedTuple):
    """The results of exploring the unedited file."""

    states: int
    idle: Mapping[str, int]
    failing: frozenset[str]


class Baseline:
    """The unedited file, explored once: an event that is impossible in it is no finding about a mutant.

    Args:
        network: the network with the constants that mutants are judged with.
        constants: these constants, as they were given.
        executed: templates that a program executes.
        variant: the name of these constants if they are not those of the tool at hand. A requirement that does not
            hold with them, such as one about an interlock that is off, is then not checked.

    Raises:
        UsageError: a requirement does not hold of the unedited file.
    """

    def __init__(
        self,
        network: Network,
        constants: Mapping[str, Given],
        executed: Collection[str],
        variant: str = "",
    ) -> None:
        self.network, self.constants, self.executed = network, constants, tuple(executed)
        self.variant = variant
        bound = network.constants.get("D")
        self.reaction = ReactionBound(self.executed, bound) if isinstance(bound, int) else None
        self._off = _disabled(network)
        if not variant and (failing := self._found.failing):
            what = f"Does not hold of the file as it is: {', '.join(sorted(failing))}."
            raise UsageError(what, todo="`eehal verify` shows a run; mutants are judged by what holds.")

    @cached_property
    def _requirements(self) -> tuple[Requirement, ...]:
        return requirements_of(self.network)

    @cached_property
    def _found(self) -> _Found:
        requirements = self._requirements
        found = overview(self.network, [each.query for each in requirements], reaction=self.reaction)
        answers = zip(requirements, found.answers, strict=True)
        return _Found(found.states, _idle(found), frozenset(each.id for each, holds in answers if not holds))

    @property
    def states(self) -> int:
        """Number of symbolic states of the unedited file."""
        return self._found.states

    @cached_property
    def reached(self) -> ReachedNetwork:
        """All states of the unedited file."""
        return ReachedNetwork(self.network, self.executed)

    def off(self, mutant: Mutant) -> bool:
        """Return whether the constants switch off the edited edge, or all edges into the edited location."""
        return self._among(self._off, mutant)

    def stays_off(self, mutant: Mutant, network: Network | None = None) -> bool:
        """Return whether the edited element is `off`, and also off in the mutant's network, so that nothing has
        changed.

        Without a network: whether this edit can switch nothing on.
        """
        if not self.off(mutant):
            return False
        if mutant.operator in ("edge deleted", "target") or mutant.element.endswith(", assignment"):
            return True
        return network is not None and self._among(_disabled(network), mutant)

    def _among(self, off: Collection[str], mutant: Mutant) -> bool:
        if not mutant.template:
            return False
        template = next(
            each for each in self.network.document.templates if each.name.content.strip() == mutant.template
        )
        if mutant.edge is not None:
            return template.edges[mutant.edge].place.where(0) in off
        into = [edge.place.where(0) for edge in template.edges if edge.target == mutant.location]
        return bool(into) and mutant.location != template.initial and set(off).issuperset(into)

    @cached_property
    def asked(self) -> tuple[Requirement, ...]:
        """The requirements that hold of the unedited file and are checked for mutants."""
        return tuple(each for each in self._requirements if each.id not in self._found.failing)

    def more_idle(self, found: Overview) -> list[str]:
        """Return the coverage checks that find more in a mutant than in the unedited file."""
        return [name for name, count in _idle(found).items() if count > self._found.idle[name]]


def judge(mutant: Mutant, baseline: Baseline) -> MutantVerdict:
    """Look for a requirement that detects the edit, unless the edit is proven to change nothing."""
    try:
        network = make_network(mutant.document, baseline.constants)
    except ModelError:
        return MutantVerdict(mutant, MutantOutcome.INVALID)
    if baseline.stays_off(mutant, network):
        return MutantVerdict(mutant, MutantOutcome.OFF)
    same = MutantOutcome.OFF if baseline.off(mutant) else MutantOutcome.EQUIVALENT
    asked_only = not mutant.template and mutant.element.endswith("no template calls")  # moves nothing
    if not asked_only and baseline.reached.equivalent(
        network, most_pairs=_FEW
    ):  # where it differs this is seen at once
        return MutantVerdict(mutant, same)
    requirements = baseline.asked
    try:
        found = _overview(network, requirements, baseline, stop=True)
        by = tuple(_caught(network, requirements, found))
        if not by and found.ended and found.states < _MORE * baseline.states:  # it was no deadlock
            found = _overview(network, requirements, baseline, stop=False)
            by = tuple(_caught(network, requirements, found))
        if not by and not found.ended:
            by = tuple(_unnoticed(network, found, baseline))
    except RangeError:
        by = ("ranges",)
    if by:
        return MutantVerdict(mutant, MutantOutcome.CAUGHT, by, baseline.variant)
    if found.ended:
        return MutantVerdict(mutant, MutantOutcome.OPEN)
    return MutantVerdict(
        mutant, same if not asked_only and baseline.reached.equivalent(network) else MutantOutcome.SURVIVES
    )


def _overview(
    network: Network, requirements: tuple[Requirement, ...], baseline: Baseline, *, stop: bool
) -> Overview:
    queries = [each.query for each in requirements]
    most = _MORE * baseline.states
    return overview(network, queries, stop=stop, most_states=most, reaction=baseline.reaction)


def _caught(network: Network, requirements: tuple[Requirement, ...], found: Overview) -> Iterator[str]:
    """Yield violated requirements; doubtful answers are checked again, after an early end only "A[]" is used."""
    explorer = Explorer(network)
    for each, answer in zip(requirements, found.answers, strict=True):
        query = each.query
        doubtful = query.kind == "-->" or "deadlock" in str(query)
        if found.ended and query.kind != "A[]":
            continue
        if answer is False or (answer is None and not (doubtful and explorer.check(query).holds)):
            yield each.id


def _unnoticed(network: Network, found: Overview, baseline: Baseline) -> Iterator[str]:
    """Yield the violated checks of every model."""
    yield from baseline.more_idle(found)
    if found.late:
        yield "room"
    explorer = Explorer(network)
    if (found.stopped and not explorer.timelock().holds) or (found.zeno and not explorer.zeno().holds):
        yield "time"


def _disabled(network: Network) -> frozenset[str]:
    """Return the places of the edges that the constants switch off."""
    return frozenset(text.partition(": ")[0] for text in Coverage().report(network).disabled)


def _idle(found: Overview) -> dict[str, int]:
    return {
        "locations": len(found.coverage.locations),
        "edges": len(found.coverage.edges),
        "channels": len(found.open_channels),
        "names": len(found.equal_names),
    }
