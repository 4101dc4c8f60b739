"""The symbolic states of a network: a discrete state and a zone over its active clocks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from timed_automata.compiler import Bound
from timed_automata.errors import ModelError
from timed_automata.explore.states._discrete import Action, DiscreteSpace, DiscreteState, Move
from timed_automata.explore.states._plan import Plan, Rearrangement
from timed_automata.explore.zones import Limit, Limits, Zone, as_constraints, widening
from timed_automata.explore.zones._extrapolation import Widening
from timed_automata.explore.zones._zone import IMPOSSIBLE, Constraint, UniqueZones


class PlannedMove(NamedTuple):
    """A move with its plan, and the record of its target."""

    plan: Plan
    target: StateRecord
    move: Move


class Form:
    """The common properties of the zones of some discrete states; equal forms are one object.

    Attributes:
        limits: limits of the active clocks.
        index: the place of every active clock in the zones; one object for all forms with the same clocks.
        n: the size of the zones.
        widening: the limits that ``extrapolated`` needs.
        invariant: constraints on the zones.
        entry: lower bounds of the invariant, which a move into the state can violate, but time cannot.
        delays: whether time passes.
        arriving: number that is equal for forms with the same constraints on the clocks of a move that enters.
        leaving: number that is equal for forms with the same constraints on the clocks of a move that leaves.
        zones: number that is equal for forms with the same constraints at the same places of the zone, even for other
            clocks.
    """

    __slots__ = (
        "arriving",
        "delays",
        "entry",
        "index",
        "invariant",
        "leaving",
        "limits",
        "n",
        "widening",
        "zones",
    )

    def __init__(
        self,
        limits: dict[int, Limit],
        index: dict[int, int],
        widening: Widening,
        bounds: tuple[Bound, ...],
        delays: bool,
    ) -> None:
        self.limits, self.index, self.widening, self.delays = limits, index, widening, delays
        self.n, self.invariant = len(index) + 1, as_constraints(bounds, index)
        self.entry = tuple(bound for bound in bounds if bound.lower)
        self.arriving = self.leaving = self.zones = 0

    @property
    def clocks(self) -> tuple[int, ...]:
        """The active clocks by their number in the network; the first is x_1 of the zones."""
        return tuple(self.index)


class StateRecord:
    """A discrete state inside one analysis, with the data that the analysis keeps about it.

    Attributes:
        discrete: the discrete state.
        form: the form of its zones.
        passed: nodes that wait or are done; set by the search.
        note: free for the user of the space.
        stage: set by the search.
    """

    __slots__ = ("_space", "_steps", "discrete", "form", "note", "passed", "stage")

    def __init__(self, space: SymbolicSpace, discrete: DiscreteState) -> None:
        self._space, self.discrete, self.form = space, discrete, space.form(discrete)
        self.passed: Sequence[Any] = ()
        self.note: Any = None
        self.stage: Any = None
        self._steps: tuple[Any, ...] | None = None  # side by side: a tuple for each is most of all memory

    @property
    def n(self) -> int:
        """The size of its zones."""
        return self.form.n

    @property
    def invariant(self) -> tuple[Constraint, ...]:
        """Constraints of the invariant on its zones."""
        return self.form.invariant

    @property
    def steps(self) -> Iterable[PlannedMove]:
        """All moves with their targets; the move itself names no target. A move whose update leaves a range has a plan
        and leads to its own source.
        """
        if self._steps is None:
            self._steps = tuple(self._space.steps(self))
        parts = iter(self._steps)
        return zip(parts, parts, parts, strict=True)  # type: ignore[return-value]

    def forget(self) -> None:
        """Drop the steps and the data of the analysis."""
        self._steps, self.passed, self.note = None, (), None

    def constraints(self, bounds: tuple[Bound, ...]) -> tuple[Constraint, ...]:
        """Return clock constraints in the places of this record's zones."""
        return as_constraints(bounds, self.form.index)


class SymbolicSpace:
    """One analysis of a network: discrete states with zones that are widened by the given limits.

    ``delays``: zones grow by time as they are entered (for reachability; equal zones are then one object); if false,
    the user lets time pass (for liveness). ``frugal``: the moves of a discrete state are not kept.
    """

    def __init__(
        self, discrete: DiscreteSpace, limits: Limits, *, delays: bool = True, widens: bool = True
    ) -> None:
        self.discrete, self.limits, self.delays, self.widens = discrete, limits, delays, widens
        self.frugal = False
        self._shared: dict[Action, Move] = {}
        self._records: dict[DiscreteState, StateRecord] = {}
        self._ways: dict[tuple[Action, int, int], dict[int, Plan]] = {}  # plans by the zones of the target
        self._same_ways: dict[object, dict[int, Plan]] = {}
        self._rearrangements: dict[object, Rearrangement] = {}
        self._forms: dict[tuple[int, int, bool], Form] = {}
        self._indices: dict[tuple[int, ...], dict[int, int]] = {}
        self._numbers: dict[object, int] = {}
        self._widenings: dict[tuple[Limit, ...], Widening] = {}
        self._unique = UniqueZones() if delays else None

    def __len__(self) -> int:
        return len(self._records)

    @property
    def records(self) -> Iterable[StateRecord]:
        """All records so far."""
        return self._records.values()

    def forget(self) -> None:
        """Drop all records."""
        for record in self._records.values():
            record.forget()
        self._records.clear()

    def drop(self, record: StateRecord) -> None:
        """Drop a record and its discrete state; they are created again when they are reached again."""
        self._records.pop(record.discrete, None)
        self.discrete.drop(record.discrete)
        record.forget()

    def form(self, discrete: DiscreteState) -> Form:
        """Return the form of the zones of a discrete state."""
        limits = self.limits.at(discrete.vector.locations)
        key = id(limits), id(discrete.invariant), discrete.delays  # equal ones are one object
        found = self._forms.get(key)
        if found is None:
            found = self._forms[key] = self._form(limits, discrete)
        return found

    def _form(self, limits: dict[int, Limit], discrete: DiscreteState) -> Form:
        by_place = tuple(limits.values())
        wide = self._widenings.get(by_place)
        if wide is None:
            wide = self._widenings[by_place] = widening(by_place)
        clocks = tuple(limits)
        index = self._indices.get(clocks)
        if index is None:
            index = self._indices[clocks] = {clock: number for number, clock in enumerate(clocks, start=1)}
        form = Form(limits, index, wide, discrete.invariant, discrete.delays)
        numbers, after = self._numbers, (by_place, form.invariant, form.delays)
        form.arriving = numbers.setdefault(("to", clocks, form.entry), len(numbers))
        form.leaving = numbers.setdefault(("from", clocks, self.asked_inside(form)), len(numbers))
        form.zones = numbers.setdefault(after, len(numbers))
        return form

    def record(self, discrete: DiscreteState) -> StateRecord:
        """Return the record of a discrete state."""
        record = self._records.get(discrete)
        if record is None:
            record = self._records[discrete] = StateRecord(self, discrete)
        return record

    def initial(self) -> tuple[StateRecord, Zone]:
        """Return the initial state of the network with all clocks zero.

        Raises:
            ModelError: an invariant does not hold there.
        """
        discrete = self.discrete.at(self.discrete.semantics.initial)
        zone = None
        if discrete is not None:
            record = self.record(discrete)
        if discrete is not None and all(bound.allows(0) for bound in discrete.invariant):
            zone = self._plan(1, (), ((0, 0),) * record.n, record.form)((1,))
        if zone is None:
            raise self._outside()
        return record, zone

    def _outside(self) -> ModelError:
        network, state = self.discrete.network, self.discrete.semantics.initial
        for process, at in zip(network.processes, state.locations, strict=True):
            location = process.locations[at]
            bounds = [part.at(state.values) for part in location.invariant.clocks]
            if not all(bound.allows(0) for bound in bounds) or not location.invariant.holds(state.values):
                text = location.drawn.labels["invariant"].text
                what = f"The invariant '{text.whole.snippet}' does not hold in the initial state."
                return ModelError(
                    what, where=text.whole.where, todo="Every process starts in its initial location."
                )
        raise AssertionError("every invariant holds in the initial state")

    def step(self, source: StateRecord, move: Move) -> PlannedMove:
        """Return the move with its plan."""
        target = source if move.target is None else self.record(move.target)
        return PlannedMove(self._way(source, move.action, target, move.error), target, move)

    def steps(self, source: StateRecord) -> list[object]:
        """Return plan, target and move of all steps in one flat list; the move is shared and names no target."""
        arcs = source.discrete.arcs() if self.frugal else source.discrete.kept_arcs()
        shared, ways, records, leaving = self._shared, self._ways, self._records, source.form.leaving
        found: list[object] = []
        for action, discrete, error in arcs:
            if discrete is None:
                found += self.step(source, Move(action, None, error))
                continue
            target = records.get(discrete) or self.record(discrete)
            form = target.form
            way = ways.get((action, leaving, form.arriving))
            plan = (way and way.get(form.zones)) or self._way(source, action, target)
            found += (plan, target, shared.get(action) or shared.setdefault(action, Move(action, None)))
        return found

    def _way(self, source: StateRecord, action: Action, target: StateRecord, error: object = None) -> Plan:
        if error is not None:
            unchanged = tuple((number, 0) for number in range(source.n))
            return self._plan(source.n, self.guard(source, action), unchanged, source.form)
        form = target.form
        key = (action, source.form.leaving, form.arriving)
        way = self._ways.get(key)
        if way is not None and (plan := way.get(form.zones)) is not None:
            return plan
        index, resets = source.form.index, action.resets
        sources = [(0, resets[x]) if x in resets else (index[x], 0) for x in form.index]
        guard = (*self.guard(source, action), *_entering(source, action, target))
        same = (source.n, guard, ((0, 0), *sources))
        if way is None:
            way = self._ways[key] = self._same_ways.setdefault(same, {})
        plan = way.get(form.zones)
        if plan is None:
            plan = way[form.zones] = self._plan(*same, form)
        return plan

    def asked_inside(self, form: Form) -> object:
        """Return the constraints on the zones of a form that guards add to those of the move; here none."""
        return None

    def guard(self, source: StateRecord, action: Action) -> tuple[Constraint, ...]:
        """Return the constraints that a move puts on the zones of a record."""
        return source.constraints(action.guard)

    def _plan(
        self, n: int, guard: tuple[Constraint, ...], sources: tuple[tuple[int, int], ...], target: Form
    ) -> Plan:
        """Return a plan for zones of size ``n``; see :class:`Plan`."""
        rearrangement = self._rearrangements.get((n, sources))
        if rearrangement is None:
            rearrangement = self._rearrangements[n, sources] = Rearrangement(n, sources)
        delays = self.delays and target.delays
        limits = target.widening if self.widens_in(target) else None
        return Plan(guard, rearrangement, delays, target.invariant, limits, self._unique)

    def widens_in(self, form: Form) -> bool:
        """Return whether zones are widened in states of this form."""
        return self.widens


def _entering(source: StateRecord, action: Action, target: StateRecord) -> Iterator[Constraint]:
    """Yield the lower bounds of the target's invariant as guards of the move, because unset clocks keep
    their values.
    """
    for bound in target.form.entry:
        if bound.clock not in action.resets:
            yield from source.constraints((bound,))
        elif not bound.allows(action.resets[bound.clock]):
            yield IMPOSSIBLE


class InvariantGuardedSpace(SymbolicSpace):
    """A space for explorations that look for deadlocks among zones widened by ExtraLU+.

    ExtraLU+ lets zones grow past invariants by valuations that are equivalent only in their transitions: some of these
    are deadlocked and represent no real deadlock. Here a transition starts inside the invariant of its source, and
    zones are widened only where time passes: a chain of committed locations is too short to need it.
    """

    def guard(self, source: StateRecord, action: Action) -> tuple[Constraint, ...]:
        """Return the constraints that a move puts on the zones of a record, including the invariant."""
        return (*super().guard(source, action), *source.invariant)

    def asked_inside(self, form: Form) -> object:
        """Return the invariant, which guards include here."""
        return form.invariant

    def widens_in(self, form: Form) -> bool:
        """Return whether time passes in states of this form; only then zones are widened."""
        return form.delays
