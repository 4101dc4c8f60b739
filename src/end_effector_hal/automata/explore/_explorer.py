"""Answers queries about a network."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial

from end_effector_hal.automata import _ast as ast
from end_effector_hal.automata._document import Query as StoredQuery
from end_effector_hal.automata._faults import RangeError, refused
from end_effector_hal.automata._network import Network
from end_effector_hal.automata._text import Text
from end_effector_hal.automata.explore._cases import Cases
from end_effector_hal.automata.explore._concrete import Leg, NoRunError, concrete
from end_effector_hal.automata.explore._coverage import Coverage, Survey
from end_effector_hal.automata.explore._delay import Only, Within
from end_effector_hal.automata.explore._discrete import DiscreteSpace
from end_effector_hal.automata.explore._extremes import Found, extreme_clock, extreme_integer
from end_effector_hal.automata.explore._formula import (
    All,
    Formula,
    compile_clock,
    compile_formula,
    compile_integer,
    limits_of,
    mentions_deadlock,
)
from end_effector_hal.automata.explore._limits import Limit, Limits, merged
from end_effector_hal.automata.explore._liveness import Lasso, Start, Staying
from end_effector_hal.automata.explore._query import Query, parse_query
from end_effector_hal.automata.explore._reach import Node, OutOfRangeError, Search
from end_effector_hal.automata.explore._symbolic import SymbolicSpace
from end_effector_hal.automata.explore._trace import Trace
from end_effector_hal.automata.explore._verdict import Verdict

_MOST_DOUBTS = 20  # deadlocks that turn out not to be: then a finer search is cheaper


class RunTimeError(RangeError):
    """A value leaves its range in a run of the network: the model is wrong, whatever the query. With its trace."""

    def __init__(self, error: OutOfRangeError, trace: Trace) -> None:
        super().__init__(error.what, where=error.where, todo=error.todo)
        self.trace = trace


class Explorer:
    """Checks any number of queries about one network; what does not depend on the query is computed once."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.discrete = DiscreteSpace(network)

    def check(self, query: Query | StoredQuery | Text | str) -> Verdict:
        """The answer to a query.

        Raises:
            ModelError: the query is not well-formed, or outside of the supported subset.
            RunTimeError: a value leaves its range in a run.
        """
        query = _read(query)
        if query.kind in ("sup", "inf"):
            return self._extremes(query)
        if query.kind in ("A[]", "E<>"):
            return self._reachability(query)
        return self._liveness(query)

    def explore_all(self) -> Coverage:
        """What every model must satisfy, whatever its queries.

        Raises:
            RunTimeError: a value leaves its range in a run.
        """
        space = SymbolicSpace(self.discrete, Limits(self.network, symmetric=True))
        with self._errors(space):
            return Survey(Search(space)).run()

    def check_all(self, queries: Iterable[Query | StoredQuery | Text | str]) -> list[Verdict]:
        """The answers to several queries, those that can be found in one search together.

        Raises:
            ModelError: as :meth:`check`.
            RunTimeError: as :meth:`check`.
        """
        read = [_read(query) for query in queries]
        answers: dict[int, Verdict] = {}
        groups: dict[frozenset[int], list[int]] = {}
        asked: dict[int, _Reachability] = {}
        for at, query in enumerate(read):
            if query.kind in ("A[]", "E<>"):
                asked[at] = _Reachability(self.network, query)
                groups.setdefault(frozenset(limits_of(asked[at].wanted)), []).append(at)
            else:
                answers[at] = self.check(query)
        for members in groups.values():
            answers.update(zip(members, self._together([asked[at] for at in members]), strict=True))
        return [answers[at] for at in range(len(read))]

    # Kinds of queries

    def _reachability(self, query: Query) -> Verdict:
        return self._together([_Reachability(self.network, query)])[0]

    def _together(self, asked: list[_Reachability]) -> list[Verdict]:
        """Answers of one search."""
        extra: dict[int, Limit] = {}
        for one in asked:
            merged(extra, limits_of(one.wanted))
        for symmetric in (False, True):
            search = Search(SymbolicSpace(self.discrete, Limits(self.network, extra, symmetric=symmetric)))
            with self._errors(search.space):
                _answer(search, [one for one in asked if one.verdict is None], trusted=symmetric)
            if all(one.verdict for one in asked):
                break
        return [one.verdict for one in asked if one.verdict]

    def _liveness(self, query: Query) -> Verdict:
        assert query.condition is not None
        sustained = query.condition if query.then is None else query.then
        staying = query.kind == "E[]"
        inside = self._without_deadlock(sustained, negated=not staying)
        outside = self._without_deadlock(sustained, negated=staying)
        extra = limits_of(All((inside, outside)))
        starts = None
        if query.then is not None:
            starts = self._without_deadlock(query.condition, negated=False)
            merged(extra, limits_of(starts))
        within, states = Within(Cases(inside), Cases(outside)), 0
        for symmetric in (False, True):
            limits = Limits(self.network, extra, symmetric=symmetric)
            space = SymbolicSpace(self.discrete, limits, delays=False)
            search = Staying(space, within, partial(_trusted if symmetric else _possible, space))
            reach = Search(SymbolicSpace(self.discrete, limits))
            with self._errors(space):
                found = (
                    [Start(*space.initial(), ())] if starts is None else _starts(reach, space, Cases(starts))
                )
                lasso = search.lasso(found)
            states += search.states + reach.states
            if lasso is not None or not search.doubts:
                break
        trace = (
            None
            if lasso is None
            else concrete(space, lasso.legs, lasso.ending, lasso.remark, loop=lasso.loop)
        )
        return Verdict(str(query), (lasso is None) != staying, states, trace)

    def _without_deadlock(self, node: ast.Expression, *, negated: bool) -> Formula:
        formula = compile_formula(self.network, node, negated=negated)
        if mentions_deadlock(formula):
            raise refused(node.span, f"'{node.span.snippet}', 'deadlock' outside of A[] and E<>")
        return formula

    def _extremes(self, query: Query) -> Verdict:
        condition: Formula = All(())
        if query.condition is not None:
            condition = self._without_deadlock(query.condition, negated=False)
        found = [self._extreme(condition, target, upper=query.kind == "sup") for target in query.targets]
        trace = None
        for one, target in zip(found, query.targets, strict=True):
            if trace is None and one.node is not None:
                remark = f"{query.kind} of {target.span.snippet}: {one.extreme}"
                trace = concrete(one.search.space, one.node.legs, one.ending, remark)
        states, extremes = sum(one.search.states for one in found), tuple(one.extreme for one in found)
        return Verdict(str(query), all(e.value is not None for e in extremes), states, trace, extremes)

    def _extreme(self, condition: Formula, target: ast.Expression, *, upper: bool) -> Found:
        clock = compile_clock(self.network, target)
        space = SymbolicSpace(self.discrete, Limits(self.network))
        with self._errors(space):
            if clock is not None:
                return extreme_clock(self.discrete, condition, clock, upper=upper)
            return extreme_integer(
                self.discrete, condition, compile_integer(self.network, target), upper=upper
            )

    @contextmanager
    def _errors(self, space: SymbolicSpace) -> Iterator[None]:
        """A value that leaves its range is told with the run that leads there."""
        try:
            yield
        except OutOfRangeError as error:
            raise RunTimeError(error, concrete(space, error.legs, _anywhere, error.what)) from None


def _read(query: Query | StoredQuery | Text | str) -> Query:
    if isinstance(query, StoredQuery):
        query = query.formula
    return query if isinstance(query, Query) else parse_query(query)


class _Reachability:
    """A query of the kind A[] or E<> that waits for its answer."""

    def __init__(self, network: Network, query: Query) -> None:
        assert query.condition is not None
        self.query, self.invariance = query, query.kind == "A[]"
        self.wanted = compile_formula(network, query.condition, negated=self.invariance)
        self.cases = Cases(self.wanted)
        self.about_deadlock = mentions_deadlock(self.wanted)
        self.remark = f"{query.condition.span.snippet}: {'does not hold' if self.invariance else 'holds'}"
        self.verdict: Verdict | None = None
        self.doubts = 0

    def decide(self, search: Search, node: Node | None) -> None:
        """Found, or not found anywhere."""
        trace = None if node is None else concrete(search.space, node.legs, self.cases.part, self.remark)
        self.verdict = Verdict(str(self.query), (node is None) == self.invariance, search.states, trace)


def _answer(search: Search, asked: list[_Reachability], *, trusted: bool) -> None:
    """Search until all are answered.

    Zones widened by ExtraLU+ hold valuations that only behave like others as far as transitions go: a deadlock that
    is found in one counts if the exact zone of the run has it too. What is left in doubt waits for ExtraM+, which
    tells deadlocked valuations from others (``trusted``).
    """
    open_ = list(asked)
    for node in search.nodes():
        answered = False
        for one in open_:
            if one.doubts < _MOST_DOUBTS and one.cases.part(node.place, node.zone) is not None:
                try:
                    one.decide(search, node)
                    answered = True
                except NoRunError:
                    if trusted or not one.about_deadlock:
                        raise
                    one.doubts += 1
        if answered:
            open_ = [one for one in open_ if one.verdict is None]
            if not open_:
                return
    for one in open_:
        if trusted or not one.doubts:
            one.decide(search, None)
        one.doubts = 0


def _starts(reach: Search, space: SymbolicSpace, cases: Cases) -> Iterator[Start]:
    """All states that satisfy the left side of ``-->``, with the ways there."""
    only = Only(cases)
    for node in reach.nodes():
        place = space.place(node.place.discrete)
        for _, zone in only(place, node.zone):
            yield Start(place, tuple(zone), (*node.legs, Leg(None, only)))


def _possible(space: SymbolicSpace, lasso: Lasso) -> bool:
    """Whether a run that ends is there without widening."""
    try:
        concrete(space, lasso.legs, lasso.ending, lasso.remark)
    except NoRunError:
        return False
    return True


def _trusted(_: SymbolicSpace, __: Lasso) -> bool:
    return True


def _anywhere(_: object, zone: tuple[int, ...]) -> tuple[int, ...]:
    return zone


def check(network: Network, query: Query | StoredQuery | Text | str) -> Verdict:
    """The answer to one query; see :meth:`Explorer.check`. For several about one network make an Explorer."""
    return Explorer(network).check(query)


def explore_all(network: Network) -> Coverage:
    """See :meth:`Explorer.explore_all`."""
    return Explorer(network).explore_all()


def worst_case(network: Network, clock: str, *, where: str = "true") -> Verdict:
    """The supremum of a clock over the states that satisfy ``where``; ``extremes[0]`` of the verdict."""
    return check(network, f"sup{{{where}}}: {clock}")
