"""The symbolic states of a network: a discrete state and a zone over its active clocks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from end_effector_hal.automata._constraints import Bound
from end_effector_hal.automata.explore._discrete import Discrete, DiscreteSpace, Move
from end_effector_hal.automata.explore._extrapolation import Widening, widening
from end_effector_hal.automata.explore._limits import Limit, Limits
from end_effector_hal.automata.explore._plan import Plan, as_constraints
from end_effector_hal.automata.explore._zone import Constraint, Zone
from end_effector_hal.errors import ModelError


class Step(NamedTuple):
    """A move with its plan, into a place."""

    plan: Plan
    target: Place
    move: Move


class Place:
    """A discrete state inside one analysis: its active clocks, and what the analysis notes about it.

    Attributes:
        discrete: the discrete state.
        clocks: the active clocks, as numbers of the network; x_1 of its zones is the first.
        n: the size of its zones.
        limits: of the active clocks.
        index: the number of each active clock in its zones.
        invariant: on its zones.
        passed: nodes that wait or are done, for the user.
        seen: their zones, for the user.
    """

    __slots__ = (
        "_space",
        "_steps",
        "clocks",
        "discrete",
        "index",
        "invariant",
        "limits",
        "n",
        "passed",
        "seen",
        "widening",
    )

    def __init__(self, space: SymbolicSpace, discrete: Discrete) -> None:
        self._space, self.discrete = space, discrete
        self.limits = space.limits.at(discrete.state.locations)
        self.clocks, self.widening, self.index = space.shape(self.limits)
        self.n = len(self.clocks) + 1
        self.invariant = as_constraints(discrete.invariant, self.index)
        self.passed: list[Any] = []
        self.seen: set[Zone] = set()
        self._steps: tuple[Step, ...] | None = None

    @property
    def steps(self) -> tuple[Step, ...]:
        """All moves that lead to a state. A move whose update leaves a range has a plan and leads to itself."""
        if self._steps is None:
            self._steps = tuple(self._space.step(self, move) for move in self.discrete.moves)
        return self._steps

    def constraints(self, bounds: tuple[Bound, ...]) -> tuple[Constraint, ...]:
        """Clock constraints over the zones of this place."""
        return as_constraints(bounds, self.index)


class SymbolicSpace:
    """One analysis of a network: discrete states with zones that are widened by the limits given.

    ``delays``: whether zones are let grow by time as they are entered (reachability) or left to the user (liveness).
    """

    def __init__(
        self, discrete: DiscreteSpace, limits: Limits, *, delays: bool = True, widens: bool = True
    ) -> None:
        self.discrete, self.limits, self.delays, self.widens = discrete, limits, delays, widens
        self._places: dict[Discrete, Place] = {}
        self._plans: dict[object, Plan] = {}
        self._shapes: dict[
            tuple[tuple[int, Limit], ...], tuple[tuple[int, ...], Widening, dict[int, int]]
        ] = {}

    def __len__(self) -> int:
        return len(self._places)

    @property
    def places(self) -> Iterable[Place]:
        """All places met so far."""
        return self._places.values()

    def shape(self, limits: dict[int, Limit]) -> tuple[tuple[int, ...], Widening, dict[int, int]]:
        """The active clocks, how to widen, and the places of the clocks; equal ones are one object."""
        key = tuple(limits.items())
        found = self._shapes.get(key)
        if found is None:
            clocks = tuple(limits)
            index = {clock: place for place, clock in enumerate(clocks, start=1)}
            found = self._shapes[key] = (clocks, widening(limits.values()), index)
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
            raise ModelError("An invariant does not hold in the initial state.")
        return place, zone

    def step(self, source: Place, move: Move) -> Step:
        """The move with its plan."""
        guard = source.constraints(move.guard)
        target = source if move.target is None else self.place(move.target)
        index = source.index
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
        return Step(self._plan(source.n, guard, sources, target), target, move)

    def _plan(
        self, n: int, guard: tuple[Constraint, ...], sources: tuple[tuple[int, int], ...], target: Place
    ) -> Plan:
        delays = self.delays and target.discrete.delays
        limits = target.widening if self.widens else None
        key = (n, guard, sources, delays, target.invariant, id(limits))
        plan = self._plans.get(key)
        if plan is None:
            plan = self._plans[key] = Plan(n, guard, sources, delays, target.invariant, limits)
        return plan
