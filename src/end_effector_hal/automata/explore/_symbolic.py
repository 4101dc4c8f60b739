"""The symbolic states of a network: a discrete state and a zone over its active clocks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from end_effector_hal.automata._constraints import Bound
from end_effector_hal.automata.explore._discrete import Discrete, DiscreteSpace, Label, Move
from end_effector_hal.automata.explore._extrapolation import widening
from end_effector_hal.automata.explore._limits import Limit, Limits
from end_effector_hal.automata.explore._plan import Plan, as_constraints
from end_effector_hal.automata.explore._zone import Constraint, Zone
from end_effector_hal.errors import ModelError


class Step(NamedTuple):
    """A move with its plan, into a place."""

    plan: Plan
    target: Place
    move: Move


class Shape:
    """The active clocks of some discrete states, and how to widen their zones; equal ones are one object.

    Attributes:
        limits: of the active clocks.
        clocks: them, as numbers of the network; x_1 of the zones is the first.
        index: the number of each active clock in the zones.
        n: the size of the zones.
        widening: what ``extrapolated`` takes.
    """

    __slots__ = ("clocks", "index", "limits", "n", "widening")

    def __init__(self, limits: dict[int, Limit]) -> None:
        self.limits, self.clocks = limits, tuple(limits)
        self.index = {clock: place for place, clock in enumerate(self.clocks, start=1)}
        self.n, self.widening = len(self.clocks) + 1, widening(limits.values())


class Place:
    """A discrete state inside one analysis: its active clocks, and what the analysis notes about it.

    Attributes:
        discrete: the discrete state.
        shape: of its zones.
        invariant: on its zones.
        passed: nodes that wait or are done, for the user.
        note: for the user.
    """

    __slots__ = (
        "_space",
        "_steps",
        "discrete",
        "invariant",
        "note",
        "passed",
        "shape",
    )

    def __init__(self, space: SymbolicSpace, discrete: Discrete) -> None:
        self._space, self.discrete = space, discrete
        self.shape = space.shape(discrete.state.locations)
        self.invariant = space.invariant(self.shape, discrete.invariant)
        self.passed: list[Any] = []
        self.note: Any = None
        self._steps: tuple[Any, ...] | None = None  # side by side: a tuple for each is most of all memory

    @property
    def n(self) -> int:
        """The size of its zones."""
        return self.shape.n

    @property
    def clocks(self) -> tuple[int, ...]:
        """The active clocks."""
        return self.shape.clocks

    @property
    def limits(self) -> dict[int, Limit]:
        """Of the active clocks."""
        return self.shape.limits

    @property
    def index(self) -> dict[int, int]:
        """The number of each active clock in its zones."""
        return self.shape.index

    @property
    def steps(self) -> Iterable[Step]:
        """All moves that lead to a state. A move whose update leaves a range has a plan and leads to itself."""
        if self._steps is None:
            step = self._space.step
            self._steps = tuple([part for move in self.discrete.moves for part in step(self, move)])
            if self._space.frugal:
                self.discrete.forget()
        parts = iter(self._steps)
        return zip(parts, parts, parts, strict=True)  # type: ignore[return-value]

    def forget(self) -> None:
        """Let go of the steps and of what was noted."""
        self._steps, self.passed, self.note = None, [], None

    def constraints(self, bounds: tuple[Bound, ...]) -> tuple[Constraint, ...]:
        """Clock constraints over the zones of this place."""
        return as_constraints(bounds, self.shape.index)


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
        self._planned: dict[object, Plan] = {}
        self._located: dict[tuple[int, ...], Shape] = {}
        self._shapes: dict[tuple[tuple[int, Limit], ...], Shape] = {}
        self._invariants: dict[object, tuple[Constraint, ...]] = {}
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

    def shape(self, locations: tuple[int, ...]) -> Shape:
        """The active clocks where the processes are in these locations."""
        found = self._located.get(locations)
        if found is None:
            limits = self.limits.at(locations)
            key = tuple(limits.items())
            found = self._shapes.get(key) or self._shapes.setdefault(key, Shape(limits))
            self._located[locations] = found
        return found

    def invariant(self, shape: Shape, bounds: tuple[Bound, ...]) -> tuple[Constraint, ...]:
        """An invariant as constraints; equal ones are one object."""
        if not bounds:
            return ()
        key = (shape, bounds)
        found = self._invariants.get(key)
        if found is None:
            found = self._invariants[key] = as_constraints(bounds, shape.index)
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
            zone = self._plan(1, (), ((0, 0),) * place.n, place)((1,))
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
        key = (
            move.label,
            source.shape,
            source.invariant,
            target.shape,
            target.invariant,
            target.discrete.delays,
        )
        plan = self._planned.get(key)
        if plan is None:
            plan = self._planned[key] = self._follow(source, move, target)
        if self.frugal and move.error is None:
            move = self._shared.get(move.label) or self._shared.setdefault(move.label, Move(move.label, None))
        return Step(plan, target, move)

    def _follow(self, source: Place, move: Move, target: Place) -> Plan:
        guard, index = self.guard(source, move), source.index
        if move.target is None:
            sources = tuple((place, 0) for place in range(source.n))
        else:
            sources = (
                (0, 0),
                *(
                    (0, move.resets[clock]) if clock in move.resets else (index[clock], 0)
                    for clock in target.clocks
                ),
            )
        return self._plan(source.n, guard, sources, target)

    def guard(self, source: Place, move: Move) -> tuple[Constraint, ...]:
        """What the zones of a place must satisfy for a move."""
        return source.constraints(move.guard)

    def _plan(
        self, n: int, guard: tuple[Constraint, ...], sources: tuple[tuple[int, int], ...], target: Place
    ) -> Plan:
        delays = self.delays and target.discrete.delays
        limits = target.shape.widening if self.widens else None
        key = (n, guard, sources, delays, target.invariant, id(limits))
        plan = self._plans.get(key)
        if plan is None:
            plan = self._plans[key] = Plan(n, guard, sources, delays, target.invariant, limits, self._unique)
        return plan
