"""Answers queries about a network."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial

from timed_automata.document import StoredQuery, Text
from timed_automata.errors import RangeError
from timed_automata.explore.properties._extremes import FoundExtreme, extreme_clock, extreme_integer
from timed_automata.explore.properties._reachability import Reachability, answer, reachability, timelock
from timed_automata.explore.properties._verdict import Verdict
from timed_automata.explore.properties._zeno import taken, zeno_run
from timed_automata.explore.search import Search, without_collector
from timed_automata.explore.search._concrete import Leg, NoRunError, anywhere, concrete
from timed_automata.explore.search._conditions import Only, Within, ZoneCondition
from timed_automata.explore.search._liveness import Lasso, LassoSearch, Start
from timed_automata.explore.search._reach import OutOfRangeError, Progress
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.states._symbolic import InvariantGuardedSpace
from timed_automata.explore.zones import Limits
from timed_automata.explore.zones._limits import QueryLimits, limits_of
from timed_automata.language import ast
from timed_automata.network import Network, Trace
from timed_automata.queries import (
    All,
    Formula,
    Query,
    compile_clock,
    compile_integer,
    compile_without_deadlock,
    parse_query,
)

AnyQuery = Query | StoredQuery | Text | str


class RunTimeError(RangeError):
    """A value leaves its range in a run of the network: the model is wrong, independent of the query. Carries its
    trace.
    """

    def __init__(self, error: OutOfRangeError, trace: Trace) -> None:
        super().__init__(error.what, where=error.where, todo=error.todo)
        self.trace = trace


class Explorer:
    """Checks any number of queries about one network; results that do not depend on the query are computed once.

    Args:
        network: a loaded network.
        progress: called now and then with the number of states of the current search; it may raise an error to end the
            search.
    """

    def __init__(self, network: Network, progress: Progress | None = None) -> None:
        self.network, self._progress = network, progress
        self.discrete = DiscreteSpace(network)

    def check(self, query: AnyQuery) -> Verdict:
        """Answer a query.

        Raises:
            ModelError: the query is not well-formed, or outside of the supported subset.
            RunTimeError: a value leaves its range in a run.
        """
        return self.check_all([query])[0]

    def check_all(self, queries: Iterable[AnyQuery]) -> list[Verdict]:
        """Answer several queries; those that one search can answer share that search.

        Raises:
            ModelError: as :meth:`check`.
            RunTimeError: as :meth:`check`.
        """
        read = [_read(query) for query in queries]
        answers: dict[int, Verdict] = {}
        groups: dict[frozenset[int], dict[int, Reachability]] = {}
        for at, query in enumerate(read):
            if query.kind in ("sup", "inf"):
                answers[at] = self._extremes(query)
            elif query.kind in ("A[]", "E<>"):
                asked = reachability(self.network, query)
                groups.setdefault(frozenset(asked.limits), {})[at] = asked
            else:
                answers[at] = self._liveness(query)
        for group in groups.values():
            answers.update(zip(group, self._together(list(group.values())), strict=True))
        return [answers[at] for at in range(len(read))]

    def timelock(self) -> Verdict:
        """Check that time can go on wherever no transition is possible; else return the shortest run to a timelock.

        Raises:
            RunTimeError: a value leaves its range in a run.
        """
        return self._together([timelock()])[0]

    def zeno(self) -> Verdict:
        """Check that time diverges in every endless run; else return a run into and round a cycle that needs no time.

        Raises:
            RunTimeError: a value leaves its range in a run.
        """
        search = Search(SymbolicSpace(self.discrete, Limits(self.network)), self._progress)
        with self._searching(search.space):
            for _ in search.nodes():
                pass
            trace = zeno_run(search, list(taken(search.space.records)))
        return Verdict("", trace is None, search.states, trace)

    # Kinds of queries

    def _together(self, asked: list[Reachability]) -> list[Verdict]:
        """Answer several questions in one search."""
        limits = [QueryLimits(one.limits) for one in asked]
        for symmetric in (False, True):
            open_ = [one for one in asked if one.verdict is None]
            sharp = not symmetric and any(one.about_deadlock for one in open_)
            kind = InvariantGuardedSpace if sharp else SymbolicSpace
            space = kind(self.discrete, Limits(self.network, limits, symmetric=symmetric))
            with self._searching(space):
                answer(Search(space, self._progress), open_, trusted=symmetric)
            if all(one.verdict for one in asked):
                break
        return [one.verdict for one in asked if one.verdict]

    def _liveness(self, query: Query) -> Verdict:
        assert query.condition is not None
        sustained = query.condition if query.then is None else query.then
        staying = query.kind == "E[]"
        inside = compile_without_deadlock(self.network, sustained, negated=not staying)
        outside = compile_without_deadlock(self.network, sustained, negated=staying)
        asked = [QueryLimits(limits_of(inside)), QueryLimits(limits_of(outside))]
        starts = None
        if query.then is not None:
            starts = compile_without_deadlock(self.network, query.condition)
            asked.append(QueryLimits(limits_of(starts)))
        within, states = Within(ZoneCondition(inside), ZoneCondition(outside)), 0
        for symmetric in (False, True):
            limits = Limits(self.network, asked, symmetric=symmetric)
            space = SymbolicSpace(self.discrete, limits, delays=False)
            search = LassoSearch(
                space, within, None if symmetric else partial(_possible, space), self._progress
            )
            reach = Search(SymbolicSpace(self.discrete, limits), self._progress)
            with self._searching(space):
                found = (
                    [Start(*space.initial(), ())]
                    if starts is None
                    else _starts(reach, space, ZoneCondition(starts))
                )
                lasso = search.lasso(found)
            states += search.states + reach.states
            if lasso is not None or not search.doubts:
                break
        trace = None
        if lasso is not None:
            trace = concrete(space, lasso.legs, lasso.ending, lasso.remark, loop=lasso.loop)
        return Verdict(str(query), (lasso is None) != staying, states, trace)

    def _extremes(self, query: Query) -> Verdict:
        condition: Formula = All(())
        if query.condition is not None:
            condition = compile_without_deadlock(self.network, query.condition)
        found = [self._extreme(condition, target, upper=query.kind == "sup") for target in query.targets]
        trace = None
        for one, target in zip(found, query.targets, strict=True):
            if trace is None and one.node is not None:
                remark = f"{query.kind} of {target.span.snippet}: {one.extreme}"
                trace = concrete(one.search.space, one.node.legs, one.ending, remark)
        states, extremes = sum(one.search.states for one in found), tuple(one.extreme for one in found)
        return Verdict(str(query), all(e.value is not None for e in extremes), states, trace, extremes)

    def _extreme(self, condition: Formula, target: ast.Expression, *, upper: bool) -> FoundExtreme:
        clock = compile_clock(self.network, target)
        space = SymbolicSpace(self.discrete, Limits(self.network))
        with self._searching(space):
            if clock is not None:
                return extreme_clock(self.discrete, condition, clock, upper=upper, progress=self._progress)
            read = compile_integer(self.network, target)
            return extreme_integer(self.discrete, condition, read, upper=upper, progress=self._progress)

    @contextmanager
    def _searching(self, space: SymbolicSpace) -> Iterator[None]:
        """Add the run that leads there to the error of a value that leaves its range."""
        try:
            with without_collector():
                yield
        except OutOfRangeError as error:
            raise RunTimeError(error, concrete(space, error.legs, anywhere, error.what)) from None


def _read(query: AnyQuery) -> Query:
    if isinstance(query, StoredQuery):
        query = query.formula
    return query if isinstance(query, Query) else parse_query(query)


def _starts(reach: Search, space: SymbolicSpace, cases: ZoneCondition) -> Iterator[Start]:
    """Yield all states that satisfy the left side of ``-->``, with the runs that lead there."""
    only = Only(cases)
    for node in reach.nodes():
        record = space.record(node.record.discrete)
        for _, zone in only(record, node.zone):
            yield Start(record, tuple(zone), (*node.legs, Leg(None, only)))


def _possible(space: SymbolicSpace, lasso: Lasso) -> bool:
    """Return whether a run that ends also exists without widening of zones."""
    try:
        concrete(space, lasso.legs, lasso.ending, lasso.remark)
    except NoRunError:
        return False
    return True


def verify(network: Network, query: AnyQuery) -> Verdict:
    """Answer one query; see :meth:`Explorer.check`. For several queries about one network, create an Explorer."""
    return Explorer(network).check(query)
