"""The proof that an edit changes no behaviour: a bisimulation between a network and an edited one.

Rule 1. Two states are related if they are the same, or differ only in variables of one process that were shown to make
no difference: from there on, both networks have the same moves into related states.
Rule 2. Two moves are the same if they use the same channel, are enabled at the same valuations of the clocks, and lead
to the same locations, the same values of all other variables, and the same values of the active clocks.
Rule 3. Time passes in the same way: the invariants allow the same valuations.

Every reachable state of the network is compared with itself in the edited network; where an edit writes another value
into a variable of a process, the two resulting states are also compared, and so on. A state in which no process is at
an edited place has the same moves in both, and is skipped. The zones of the search contain every reachable valuation,
and some that behave alike. An equivalence that is shown is therefore true; one that is not shown may still be true.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence

from timed_automata.compiler import Bound
from timed_automata.errors import RangeError
from timed_automata.explore.search import Search, without_collector
from timed_automata.explore.states import DiscreteSpace, DiscreteState, Move, StateRecord, SymbolicSpace
from timed_automata.explore.zones import Limits, Zone, constrained, included, up
from timed_automata.network import Network

from ._edited import edited_places
from ._moves import ComparedMove, moves_of, place
from ._regions import same_union

_MOST_PAIRS = 50_000
_Place = tuple[tuple[int, ...], bytes]
_Pair = tuple[DiscreteState, DiscreteState, Zone]


class ReachedNetwork:
    """A network with all its reachable states, for the comparison with edited ones.

    Args:
        network: the network that edited ones are compared with.
        templates: the edited templates; variables declared in them are private to them.

    Raises:
        RangeError: a value leaves its range in a run.
    """

    def __init__(self, network: Network, templates: Collection[str]) -> None:
        self.network = network
        own = tuple(f"{process.name}." for process in network.processes if process.template in templates)
        self._seen = [at for name, at in network.offsets.items() if not name.startswith(own)] if own else None
        self._limits = Limits(network)
        self.space = SymbolicSpace(DiscreteSpace(network), self._limits)
        self.reached: list[tuple[StateRecord, Sequence[Zone]]] = []
        with without_collector():
            for _ in Search(self.space).nodes():
                pass
            for record in self.space.records:
                if record.passed:
                    self.reached.append((record, [node.zone for node in record.passed]))
        self._known: dict[DiscreteState, tuple[ComparedMove, ...]] = {}

    def equivalent(self, edited: Network, *, most_pairs: int = _MOST_PAIRS) -> bool:
        """Return whether an edited network was shown to be equivalent; False: it was not shown.

        At most ``most_pairs`` pairs of different states are compared.

        The edit may be in guards, invariants, updates, synchronisations, targets and kinds of locations, and in
        functions; processes, locations, variables, clocks and channels must be those of the network.
        """
        if not self._comparable(edited):
            return False
        try:
            with without_collector():
                return _Comparison(self, edited, most_pairs).holds()
        except RangeError:
            return False

    def _comparable(self, edited: Network) -> bool:
        ours, theirs = (
            (
                network.initial,
                network.clocks,
                network.variables,
                network.channels,
                [(each.name, [at.name for at in each.locations]) for each in network.processes],
            )
            for network in (self.network, edited)
        )
        return ours == theirs

    def moves(self, state: DiscreteState) -> tuple[ComparedMove, ...]:
        """Return the moves of a state, cached."""
        found = self._known.get(state)
        if found is None:
            found = self._known[state] = tuple(moves_of(state))
        return found

    def seen(self, state: DiscreteState) -> object:
        """Return the part of a state that other processes can observe."""
        if self._seen is None:
            return place(state)
        values = state.state.values
        return state.vector.locations, tuple([values[at] for at in self._seen])

    def active(self, state: DiscreteState) -> Collection[int]:
        """Return the clocks whose values may be tested."""
        return self._limits.at(state.vector.locations)


class _Comparison:
    def __init__(self, reached: ReachedNetwork, edited: Network, most_pairs: int) -> None:
        self._reached, self._space = reached, reached.space
        self._most_pairs = most_pairs
        self._edited, self._limits = DiscreteSpace(edited), Limits(edited)
        self._waiting: deque[_Pair] = deque()
        self._passed: dict[tuple[_Place, _Place], list[Zone]] = {}
        self._pairs = 0
        self._places = edited_places(reached.network, edited)

    def _may_differ(self, state: DiscreteState) -> bool:
        """Return whether a process is at an edited place."""
        at = state.vector.locations
        return self._places is None or any(at[each.process] in each.locations for each in self._places)

    def holds(self) -> bool:
        for record, zones in self._reached.reached:
            state = record.discrete
            if not self._may_differ(state):
                continue
            other = self._edited.at(state.state)
            if other is None:
                return False
            if not self._plainly_same(state, other) and not all(
                self._same(record, other, zone) for zone in zones
            ):
                return False
        while self._waiting:
            state, other, zone = self._waiting.popleft()
            if not self._same(self._space.record(state), other, zone):
                return False
        return True

    def _plainly_same(self, state: DiscreteState, other: DiscreteState) -> bool:
        """Return whether moves and invariant are the same for all clock values."""
        if state.delays != other.delays or state.invariant != other.invariant:
            return False
        ours, theirs = self._reached.moves(state), list(moves_of(other))
        return len(ours) == len(theirs) and all(
            one.plain == another.plain for one, another in zip(ours, theirs, strict=True)
        )

    def _same(self, record: StateRecord, other: DiscreteState, zone: Zone) -> bool:
        """Return whether two states behave alike in a zone; pairs of successors are compared later."""
        state = record.discrete
        if state.delays != other.delays:
            return False
        inside = constrained(zone, record.n, record.invariant)
        if inside is None:
            return True
        return self._same_time(record, other, inside) and self._same_moves(record, other, inside)

    def _same_time(self, record: StateRecord, other: DiscreteState, zone: Zone) -> bool:
        if record.discrete.invariant == other.invariant:
            return True
        if any(bound.clock not in record.form.index for bound in other.invariant):
            return False
        invariant = self._constrained(record, zone, other.invariant)
        if invariant is None or not included(zone, invariant):
            return False
        if not record.discrete.delays:
            return True
        later = self._constrained(record, up(zone, record.n), other.invariant)
        ours = constrained(up(zone, record.n), record.n, record.invariant)
        return later is not None and ours is not None and included(later, ours) and included(ours, later)

    def _same_moves(self, record: StateRecord, other: DiscreteState, zone: Zone) -> bool:
        ours = self._by_label(record, self._reached.moves(record.discrete), zone)
        theirs = self._by_label(record, tuple(moves_of(other)), zone)
        if ours is None or theirs is None or ours.keys() != theirs.keys():
            return False
        return all(self._match(record, ours[label], theirs[label], zone) for label in ours)

    def _by_label(
        self, record: StateRecord, moves: Sequence[ComparedMove], zone: Zone
    ) -> dict[object, dict[_Place, tuple[DiscreteState, list[Zone]]]] | None:
        """Group the possible moves in a zone by their observable effect, then by their target.

        None: a move tests a clock whose value is unknown.
        """
        found: dict[object, dict[_Place, tuple[DiscreteState, list[Zone]]]] = {}
        index = record.form.index
        for move in moves:
            if any(bound.clock not in index for bound in move.bounds):
                return None
            enabled = self._constrained(record, zone, move.bounds)
            if enabled is None:
                continue
            resets = tuple(self._resets(record, move, enabled))
            label = (move.channel, resets, self._reached.seen(move.target))
            targets = found.setdefault(label, {})
            targets.setdefault(place(move.target), (move.target, []))[1].append(enabled)
        return found

    def _resets(self, record: StateRecord, move: ComparedMove, zone: Zone) -> Iterator[tuple[int, int]]:
        """Yield the clock resets that change a value and matter."""
        index, n = record.form.index, record.n
        active = {*self._reached.active(move.target), *self._limits.at(move.target.vector.locations)}
        for clock, value in move.resets:
            if clock in active:
                at = index.get(clock)
                pinned = at is not None and zone[at * n] == 2 * value + 1 and zone[at] == 1 - 2 * value
                if not pinned:
                    yield clock, value

    def _match(
        self,
        record: StateRecord,
        ours: dict[_Place, tuple[DiscreteState, list[Zone]]],
        theirs: dict[_Place, tuple[DiscreteState, list[Zone]]],
        zone: Zone,
    ) -> bool:
        """Return whether the moves with one label lead to the same states, or to pairs to be compared."""
        for key in ours.keys() & theirs.keys():
            if not same_union(ours[key][1], theirs[key][1], record.n):
                return False
        left = [ours[key] for key in ours if key not in theirs]
        right = [theirs[key] for key in theirs if key not in ours]
        if len(left) != len(right):
            return False
        for (target, zones), (other, other_zones) in zip(left, right, strict=True):
            if target.invariant != other.invariant or not same_union(zones, other_zones, record.n):
                return False
            if not self._put_off(record, target, other, zone):
                return False
        return True

    def _put_off(self, record: StateRecord, target: DiscreteState, other: DiscreteState, zone: Zone) -> bool:
        """Schedule the comparison of two states; return False if there are too many."""
        passed = self._passed.setdefault((place(target), place(other)), [])
        for move in self._moves_to(record, target):
            after = self._space.step(record, move).plan(zone)
            if after is None or any(included(after, known) for known in passed):
                continue
            passed.append(after)
            self._pairs += 1
            self._waiting.append((target, other, after))
        return self._pairs <= self._most_pairs

    def _moves_to(self, record: StateRecord, target: DiscreteState) -> Iterator[Move]:
        return (move for move in record.discrete.moves if move.target is target)

    @staticmethod
    def _constrained(record: StateRecord, zone: Zone, bounds: Sequence[Bound]) -> Zone | None:
        return constrained(zone, record.n, record.constraints(tuple(bounds)))
