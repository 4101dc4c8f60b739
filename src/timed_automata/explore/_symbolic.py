"""The symbolic states of a network: a discrete state and a zone over its active clocks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from timed_automata import Bound
from timed_automata.errors import ModelError
from timed_automata.explore._discrete import Discrete, DiscreteSpace, Move
from timed_automata.explore._extrapolation import Widening, widening
from timed_automata.explore._firing import Label
from timed_automata.explore._limits import Limit, Limits
from timed_automata.explore._plan import Plan, as_constraints
from timed_automata.explore._zone import Constraint, Zone


class Step(NamedTuple):
    """A move with its plan, into a place."""

    plan: Plan
    target: Place
    move: Move


class Form:
    """What the zones of some discrete states have in common; equal ones are one object.

    Attributes:
        limits: of the active clocks.
        clocks: them, as numbers of the network; x_1 of the zones is the first.
        index: the number of each active clock in the zones.
        n: the size of the zones.
        widening: what ``extrapolated`` takes.
        invariant: on the zones.
        delays: whether time passes.
    """

    __slots__ = ("clocks", "delays", "index", "invariant", "limits", "n", "widening")

    def __init__(
        self, limits: dict[int, Limit], widening: Widening, bounds: tuple[Bound, ...], delays: bool
    ) -> None:
        self.limits, self.clocks, self.widening, self.delays = limits, tuple(limits), widening, delays
        self.index = {clock: place for place, clock in enumerate(self.clocks, start=1)}
        self.n, self.invariant = len(self.clocks) + 1, as_constraints(bounds, self.index)


class Place:
    """A discrete state inside one analysis, and what the analysis notes about it.

    Attributes:
        discrete: the discrete state.
        form: of its zones.
        passed: nodes that wait or are done, for the user.
        note: for the user.
    """

    __slots__ = ("_space", "_steps", "discrete", "form", "note", "passed")

    def __init__(self, space: SymbolicSpace, discrete: Discrete) -> None:
        self._space, self.discrete, self.form = space, discrete, space.form(discrete)
        self.passed: list[Any] = []
        self.note: Any = None
        self._steps: tuple[Any, ...] | None = None  # side by side: a tuple for each is most of all memory

    @property
    def n(self) -> int:
        """The size of its zones."""
        return self.form.n

    @property
    def clocks(self) -> tuple[int, ...]:
        """The active clocks."""
        return self.form.clocks

    @property
    def limits(self) -> dict[int, Limit]:
        """Of the active clocks."""
        return self.form.limits

    @property
    def index(self) -> dict[int, int]:
        """The number of each active clock in its zones."""
        return self.form.index

    @property
    def invariant(self) -> tuple[Constraint, ...]:
        """On its zones."""
        return self.form.invariant

    @property
    def steps(self) -> Iterable[Step]:
        """All moves that lead to a state. A move whose update leaves a range has a plan and leads to itself."""
        if self._steps is None:
            self._steps = tuple(self._space.steps(self))
        parts = iter(self._steps)
        return zip(parts, parts, parts, strict=True)  # type: ignore[return-value]

    def forget(self) -> None:
        """Let go of the steps and of what was noted."""
        self._steps, self.passed, self.note = None, [], None

    def constraints(self, bounds: tuple[Bound, ...]) -> tuple[Constraint, ...]:
        """Clock constraints over the zones of this place."""
        return as_constraints(bounds, self.form.index)


class SymbolicSpace:
    """One analysis of a network: discrete states with zones that are widened by the limits given.

    ``delays``: whether zones are let grow by time as they are entered (reachability: equal zones are then one object)
    or left to the user (liveness). ``frugal``: what moves lead to is told by steps only.
    """

    def __init__(
        self, discrete: DiscreteSpace, limits: Limits, *, delays: bool = True, widens: bool = True
    ) -> None:
        self.discrete, self.limits, self.delays, self.widens = discrete, limits, delays, widens
        self.frugal = False
        self._shared: dict[Label, Move] = {}
        self._places: dict[Discrete, Place] = {}
        self._plans: dict[object, Plan] = {}
        self._planned: dict[tuple[Label, Form, Form], Plan] = {}
        self._formed: dict[object, Form] = {}
        self._forms: dict[object, Form] = {}
        self._widenings: dict[object, Widening] = {}
        self._unique: dict[Zone, Zone] | None = {} if delays else None

    def __len__(self) -> int:
        return len(self._places)

    @property
    def places(self) -> Iterable[Place]:
        """All places met so far."""
        return self._places.values()

    def forget(self) -> None:
        """Let go of all places."""
        for place in self._places.values():
            place.forget()
        self._places.clear()

    def form(self, discrete: Discrete) -> Form:
        """What the zones of a discrete state are like."""
        seen = (discrete.stand, discrete.invariant, discrete.delays)
        found = self._formed.get(seen)
        if found is None:
            limits = self.limits.at(discrete.stand.locations)
            key = (tuple(limits.items()), *seen[1:])
            found = self._forms.get(key)
            if found is None:
                wide = self._widenings.setdefault(key[0], widening(limits.values()))
                found = self._forms[key] = Form(limits, wide, discrete.invariant, discrete.delays)
            self._formed[seen] = found
        return found

    def place(self, discrete: Discrete) -> Place:
        """The place of a discrete state."""
        place = self._places.get(discrete)
        if place is None:
            place = self._places[discrete] = Place(self, discrete)
        return place

    def initial(self) -> tuple[Place, Zone]:
        """Where a network starts: all clocks zero.

        Raises:
            ModelError: an invariant does not hold there.
        """
        discrete = self.discrete.at(self.discrete.semantics.initial)
        zone = None
        if discrete is not None:
            place = self.place(discrete)
            zone = self._plan(1, (), ((0, 0),) * place.n, place.form)((1,))
        if zone is None:
            raise self._outside()
        return place, zone

    def _outside(self) -> ModelError:
        network, state = self.discrete.network, self.discrete.semantics.initial
        for process, at in zip(network.processes, state.locations, strict=True):
            location = process.locations[at]
            bounds = [part.at(state.values) for part in location.invariant.clocks]
            late = any(value < 0 or (not value and op == "<") for _, op, value in bounds)
            if late or not location.invariant.holds(state.values):
                text = location.drawn.labels["invariant"].text
                what = f"The invariant '{text.whole.snippet}' does not hold in the initial state."
                return ModelError(
                    what, where=text.whole.where, todo="Every process starts in its initial location."
                )
        raise AssertionError("every invariant holds in the initial state")

    def step(self, source: Place, move: Move) -> Step:
        """The move with its plan."""
        target = source if move.target is None else self.place(move.target)
        return Step(self._way(source, move.label, target, move.error), target, move)

    def steps(self, source: Place) -> Iterator[object]:
        """Plan, target and move of each step, one after the other."""
        if self.frugal:
            shared, planned, places, form = self._shared, self._planned, self._places, source.form
            for label, discrete, error in source.discrete.arcs():
                if discrete is None:
                    yield from self.step(source, Move(label, None, error))
                    continue
                target = places.get(discrete) or self.place(discrete)
                yield planned.get((label, form, target.form)) or self._way(source, label, target)
                yield target
                yield shared.get(label) or shared.setdefault(label, Move(label, None))
        else:
            for move in source.discrete.moves:
                yield from self.step(source, move)

    def _way(self, source: Place, label: Label, target: Place, error: object = None) -> Plan:
        if error is not None:
            unchanged = tuple((place, 0) for place in range(source.n))
            return self._plan(source.n, self.guard(source, label), unchanged, source.form)
        key = (label, source.form, target.form)
        plan = self._planned.get(key)
        if plan is None:
            index, resets = source.index, label.resets
            sources = [(0, resets[x]) if x in resets else (index[x], 0) for x in target.clocks]
            guard = self.guard(source, label)
            plan = self._planned[key] = self._plan(source.n, guard, ((0, 0), *sources), target.form)
        return plan

    def guard(self, source: Place, label: Label) -> tuple[Constraint, ...]:
        """What the zones of a place must satisfy for a move."""
        return source.constraints(label.guard)

    def _plan(
        self, n: int, guard: tuple[Constraint, ...], sources: tuple[tuple[int, int], ...], target: Form
    ) -> Plan:
        """The one for zones of size ``n``; see :class:`Plan`."""
        delays = self.delays and target.delays
        limits = target.widening if self.widens_in(target) else None
        key = (n, guard, sources, delays, target.invariant, id(limits))
        plan = self._plans.get(key)
        if plan is None:
            plan = self._plans[key] = Plan(n, guard, sources, delays, target.invariant, limits, self._unique)
        return plan

    def widens_in(self, form: Form) -> bool:
        """Whether zones are widened there."""
        return self.widens
