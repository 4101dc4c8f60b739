"""What symbolic states share: plans, and zones."""

from __future__ import annotations

import tracemalloc

from tests.unit.timed_automata.explore.classics import fischer
from tests.unit.timed_automata.explore.models import Template, network
from timed_automata.explore.search import Search
from timed_automata.explore.search._stages import SearchNode
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits, included
from timed_automata.explore.zones._zone import INFINITY, UniqueZones, at_most, below


def test_moves_that_are_alike_but_for_their_clocks_share_a_plan() -> None:
    """Each process of Fischer's protocol may ask first: what becomes of the zone is the same, of another clock."""
    model = fischer(3)
    space = SymbolicSpace(DiscreteSpace(model), Limits(model))
    first, _ = space.initial()
    plans, targets = zip(*[(plan, target) for plan, target, _ in first.steps], strict=True)
    assert len({target.form.clocks for target in targets}) == 3
    assert len(set(map(id, plans))) == 1


def test_equal_zones_of_a_search_are_one_object() -> None:
    search = Search(SymbolicSpace(DiscreteSpace(model := fischer(3)), Limits(model)))
    zones = {id(node.zone): tuple(node.zone) for node in search.nodes()}
    assert len(zones) == len(set(zones.values())) > 10


def test_zones_with_one_hash_stay_apart() -> None:
    """``x >= 1`` and ``x > 1``: Python hashes -1 as -2."""
    least, more = ((1, bound, INFINITY, 1) for bound in (at_most(-1), below(-1)))
    assert hash(least) == hash(more)
    unique = UniqueZones()
    found = [unique.of(zone) for zone in (least, more, least, more)]
    assert [tuple(zone) for zone in found] == [least, more, least, more]
    assert found[0] is found[2] is not found[1] is found[3]
    assert len(unique) == 2


def test_many_zones_of_one_discrete_state_take_memory_for_themselves_only() -> None:
    """Pairs that were compared are not remembered: that would take 12 kB for each state here."""
    resets = [f"a -> a; guard: x{i} >= {1 + i}; do: x{i} = 0" for i in range(4)]
    invariant = " && ".join(f"x{i} <= {2 + i}" for i in range(4))
    model = network("clock x0, x1, x2, x3;", Template("P", resets, invariants={"a": invariant}))
    tracemalloc.start()
    search = Search(SymbolicSpace(DiscreteSpace(model), Limits(model)))
    states = sum(1 for _ in search.nodes())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    left = search.space.initial()[0].passed
    assert states > 400
    assert not any(_inside(one, other) for one in left for other in left if one is not other)
    assert peak < 4_000 * states, peak / states


def _inside(one: SearchNode, other: SearchNode) -> bool:
    return included(one.zone, other.zone)
