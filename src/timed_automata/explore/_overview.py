"""Checks a network in one exploration: reachability queries, worst cases, coverage, and progress of time.

It is made for the usual case that all properties hold: it keeps nothing that only a counterexample needs. For a
property that it cannot show, use :class:`Explorer`, which finds the shortest run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from timed_automata.explore.properties import Coverage
from timed_automata.explore.properties._coverage_report import CoverageReport, equal_names, open_channels
from timed_automata.explore.properties._responses import BoundedResponse, LeadsTo, bounded
from timed_automata.explore.properties._room import ReactionBound, Room
from timed_automata.explore.properties._zeno import taken, zeno_cycle
from timed_automata.explore.search import without_collector
from timed_automata.explore.search._conditions import ZoneCondition
from timed_automata.explore.search._deadlock import Deadlocks
from timed_automata.explore.search._reach import Progress, WidestFirst
from timed_automata.explore.search._stages import SearchNode, Stage
from timed_automata.explore.states import DiscreteSpace, StateRecord, SymbolicSpace
from timed_automata.explore.states._semantics import SlicedSemantics
from timed_automata.explore.states._symbolic import InvariantGuardedSpace
from timed_automata.explore.zones import Limit, Limits
from timed_automata.explore.zones._limits import QueryLimits, limits_of, tested_clocks
from timed_automata.language import ast
from timed_automata.network import Network
from timed_automata.queries import (
    ConditionFilter,
    Data,
    Formula,
    Query,
    compile_formula,
    location_of,
    mentions_deadlock,
)


@dataclass(frozen=True, slots=True)
class Overview:
    """The results of one exploration.

    Attributes:
        states: number of symbolic states that were stored.
        answers: True for every query that holds; None if it may not hold, or if its kind is not answered here.
        unmet: numbers of the queries ``A[] p imply q`` and ``p --> q`` whose p holds nowhere.
        bounded: the queries ``A[] p imply x <= c`` by number, with the longest time seen.
        coverage: locations and edges that cannot happen.
        open_channels: channels without a sender or without a receiver, in words.
        equal_names: constants that name the same value of a type, in words.
        late: locations of executed processes that leave reactions more or less room than they need, in words.
        stuck: whether there may be a state without any transition, now or later.
        stopped: whether there may be one of these states in which time cannot go on either.
        zeno: whether there may be a cycle on which no time needs to pass.
        ended: whether the exploration ended early.
    """

    states: int
    answers: tuple[bool | None, ...]
    unmet: frozenset[int]
    bounded: Mapping[int, BoundedResponse]
    coverage: CoverageReport
    open_channels: tuple[str, ...]
    equal_names: tuple[str, ...]
    late: tuple[str, ...]
    stuck: bool
    stopped: bool
    zeno: bool
    ended: bool


def overview(
    network: Network,
    queries: Sequence[Query],
    progress: Progress | None = None,
    *,
    stop: bool = False,
    most_states: int | None = None,
    reaction: ReactionBound | None = None,
) -> Overview:
    """Explore a network once.

    Args:
        network: a loaded network.
        queries: any queries; those of other kinds than ``A[]``, ``E<>`` and ``-->`` are not answered.
        progress: called now and then with the number of states; it may raise an error to end the exploration.
        stop: end at the first ``A[]`` that may not hold; the other results are then meaningless.
        most_states: end after that many states; the results then cover only these states.
        reaction: reaction bound of the executed templates, for `late`; None: nothing is executed.

    Raises:
        ModelError: a query is not well-formed.
        OutOfRangeError: a value leaves its range in a run; the error does not contain the run.
    """
    with without_collector():
        exploration = _Exploration(network, queries, progress, reaction)
        try:
            exploration.run(stop=stop, most_states=most_states)
            return exploration.result()
        finally:
            exploration.close()


class _Exploration:
    def __init__(
        self,
        network: Network,
        queries: Sequence[Query],
        progress: Progress | None = None,
        reaction: ReactionBound | None = None,
    ) -> None:
        self.network, self.queries, self._progress = network, queries, progress
        self._unseen: dict[tuple[int, bool], Data] = {}  # number of the query; False: only its premise
        self._expected: set[tuple[int, bool]] = set()  # those that should happen
        self._cases: dict[int, ZoneCondition] = {}
        self._bounded: dict[int, BoundedResponse] = {}
        self._responses: dict[int, LeadsTo] = {}
        self._no_deadlock: set[int] = set()  # ask for nothing else
        self._about_deadlock: set[int] = set()  # ask for deadlocks among other things
        self._happened: set[tuple[int, bool]] = set()
        self._premises: dict[int, Formula] = {}
        self._deadlocks, self._doubtful = Deadlocks(), set[StateRecord]()
        self._coverage = Coverage()
        self._room = Room(network, reaction or ReactionBound((), 0))
        self._stuck = self._stopped = self._zeno = self._ended = False
        self._asked = [
            QueryLimits(self._ask(number, query), _where(network, query))
            for number, query in enumerate(queries)
        ]
        discrete = DiscreteSpace(network, SlicedSemantics(network, [str(query) for query in queries]))
        self.space = InvariantGuardedSpace(discrete, Limits(network, self._asked))
        self.space.frugal = True
        self._later = SymbolicSpace(discrete, Limits(network, self._asked, symmetric=True), delays=False)
        asked_for = {clock for asked in self._asked for clock in asked.limits}
        clocks = sorted(asked_for - tested_clocks(network))
        self.search = WidestFirst(self.space, clocks, progress, self._finish)

    def _ask(self, number: int, query: Query) -> Mapping[int, Limit]:
        """Prepare for a query, and return the limits of clocks that it needs."""
        if query.kind == "-->":
            response = self._responses[number] = LeadsTo(self.network, query)
            self._premises[number] = response.premise
            return response.limits
        if query.kind not in ("A[]", "E<>") or query.condition is None:
            return {}
        if _is_no_deadlock(query):
            self._no_deadlock.add(number)
            return {}
        if (bound := bounded(self.network, query)) is not None:
            self._bounded[number] = bound
            self._premises[number] = bound.premise
            return bound.limits
        invariance = query.kind == "A[]"
        wanted = compile_formula(self.network, query.condition, negated=invariance)
        if not isinstance(wanted, Data):
            self._cases[number] = ZoneCondition(wanted)
            self._premises[number] = wanted
            if mentions_deadlock(wanted):
                self._about_deadlock.add(number)
            return limits_of(wanted)
        self._unseen[number, True] = wanted
        if not invariance:
            self._expected.add((number, True))
        elif isinstance(query.condition, ast.Binary) and query.condition.op == "imply":
            premise = compile_formula(self.network, query.condition.left)
            if isinstance(premise, Data):  # of clocks it asks only where constants decide the rest
                self._unseen[number, False] = premise
                self._expected.add((number, False))
        return {}

    def run(self, *, stop: bool, most_states: int | None = None) -> None:
        """Explore the network."""
        concern, refuted = ConditionFilter(self.network, self._premises), self._filter_refuted()
        left = set(self._expected)
        # compiled again only when half of them have happened: that takes longer than to ask for some in vain
        expected, fewer = self._filter(left), len(left) // 2
        for count, node in enumerate(self.search.nodes(), start=1):
            record = node.record
            concerned: tuple[int, ...] | None = record.note
            if concerned is None:
                state = record.discrete.state
                if left and (happened := expected(state)):
                    left.difference_update(happened)
                    self._happened.update(happened)
                    if len(left) <= fewer:
                        expected, fewer = self._filter(left), len(left) // 2
                if happened := refuted(state):
                    self._happened.update(happened)
                    refuted = self._filter_refuted()
                concerned = record.note = concern(state)
                self._room.add(record)
                if not self._deadlocks.ruled_out(record):
                    self._doubtful.add(record)
            for number in concerned:
                self._add(number, node)
            if record in self._doubtful and not self._stopped:
                self._doubt(node)
            if (stop and self._refuted) or count == most_states:
                self._ended = True
                return

    def _filter(self, keys: Collection[tuple[int, bool]]) -> ConditionFilter[tuple[int, bool]]:
        return ConditionFilter(self.network, {key: self._unseen[key] for key in keys})

    def _filter_refuted(self) -> ConditionFilter[tuple[int, bool]]:
        """Return one filter for all conditions on data that must not hold and have not been seen to hold yet."""
        return self._filter(self._unseen.keys() - self._expected - self._happened)

    @property
    def _refuted(self) -> bool:
        invariants = (
            number for number, whole in self._happened if whole and self.queries[number].kind == "A[]"
        )
        late = any(not bound.holds for bound in self._bounded.values())
        return late or (self._stuck and bool(self._no_deadlock)) or any(True for _ in invariants)

    def _add(self, number: int, node: SearchNode) -> None:
        if number in self._bounded:
            self._bounded[number].add(node)
        elif number in self._responses:
            self._responses[number].add(node)
        elif (number, True) not in self._happened and self._cases[number].part(node.record, node.zone):
            self._happened.add((number, True))

    def _doubt(self, node: SearchNode) -> None:
        """Look for a deadlock in a symbolic state. Its zone may be too large, never too small."""
        record, discrete = node.record, node.record.discrete
        if self._deadlocks.of(record, node.zone):
            self._stuck = True
            self._stopped = not discrete.endless

    def _tell(self, _: int) -> None:
        """Report progress of a search inside this one."""
        if self._progress is not None:
            self._progress(self.search.states)

    def _finish(self, stage: Stage) -> None:
        """Judge a stage as a whole, then drop its states."""
        arcs = list(taken(stage.records))
        self._coverage.add(stage.records, arcs)
        within = [one for one in arcs if one[1].stage is stage]  # no cycle leaves a stage
        self._zeno = self._zeno or zeno_cycle(within) is not None
        for response in self._responses.values():
            response.judge(self._later, self._tell)
        self._later.forget()
        for bound in self._bounded.values():
            bound.forget()
        for condition in self._cases.values():
            condition.forget()
        self._deadlocks.forget()
        self._doubtful.difference_update(stage.records)
        for record in stage.records:
            for _, target, _ in record.steps:
                if not target.passed:
                    self.space.drop(target)
        for record in stage.records:
            self.space.drop(record)

    def result(self) -> Overview:
        """Return the results."""
        return Overview(
            states=self.search.states,
            answers=tuple(map(self._answer, range(len(self.queries)))),
            unmet=frozenset(self._unmet()),
            bounded=self._bounded,
            coverage=self._coverage.report(self.network),
            open_channels=tuple(open_channels(self.network)),
            equal_names=tuple(equal_names(self.network)),
            late=self._room.missing,
            stuck=self._stuck,
            stopped=self._stopped,
            zeno=self._zeno,
            ended=self._ended,
        )

    def close(self) -> None:
        """Break reference cycles, so that all memory is freed at once: finding the cycles takes a tenth of the time."""
        self.space.forget()
        self.space.discrete.forget()

    def _answer(self, number: int) -> bool | None:
        if number in self._no_deadlock:
            return None if self._stuck else True
        if number in self._bounded:
            return self._bounded[number].holds or None
        if number in self._responses:
            return (self._responses[number].holds and not self._ended) or None
        if self.queries[number].kind not in ("A[]", "E<>"):
            return None
        shows, happened = self.queries[number].kind == "E<>", (number, True) in self._happened
        if happened and (not shows or number in self._about_deadlock):
            return None  # of a deadlock the zones may say too much
        return happened or not shows

    def _unmet(self) -> Iterator[int]:
        open_ = self._unseen.keys() - self._happened
        yield from (number for number, whole in open_ if not whole)
        yield from (number for number, bound in self._bounded.items() if not bound.met)
        yield from (number for number, response in self._responses.items() if not response.met)


def _where(network: Network, query: Query) -> tuple[int, int] | None:
    """Return the location that a query names, as process and location; None if it names none, or if it is neither
    ``A[] … imply …`` nor ``E<>``.
    """
    match query:
        case Query(kind="A[]", condition=ast.Binary(op="imply", left=premise)):
            return location_of(network, premise)
        case Query(kind="E<>"):
            return location_of(network, query.condition)
    return None


def _is_no_deadlock(query: Query) -> bool:
    match query:
        case Query(kind="A[]", condition=ast.Unary(op="!", operand=ast.Name(name="deadlock"))):
            return True
    return False
