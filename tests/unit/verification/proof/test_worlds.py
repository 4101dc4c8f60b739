"""What the worlds of the shipped model leave out changes no state of the programs."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from types import MappingProxyType

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from tests.support.nightly import first_of
from timed_automata import load_network, make_network, read_document
from timed_automata.explore import overview
from timed_automata.explore.search import Search
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits
from timed_automata.queries import parse_query

pytestmark = pytest.mark.nightly  # long

ONE_IS_ENOUGH = """    if (j == focus || j == witness() || any_odd()) return j == focus || odd == -1 || odd == j;
    return level == PARTIAL ? odd == -1 &amp;&amp; valve[j] : odd == j &amp;&amp; level == usual(j);
"""
ANY_OF_THEM = "    return j == focus || odd == -1 || odd == j;\n"
OF_THE_WORLD = (
    "evidence",
    "vented",
    "parked",
    "supply_ok",
    "Sensors.focus",
    "Sensors.odd",
    "Sensors.emptied",
)


def test_apart_reaches_every_state_of_grip_that_anything_reaches() -> None:
    """A will is computed from these: so deaths in APART are deaths in every state."""
    description = load(profile_path())
    network = load_network(description.automata_path, model_constants(description))
    states = list(product(range(7), (-1, 2, 3, 4), (0, 1), (0, 1), (0, 1)))
    asked = [
        f"E<> world == {world} && ee == {ee} && command == {command}"
        f" && valve[0] == {a} && valve[1] == {b} && valve[2] == {c} && world > 0"
        for world in ("ANYTHING", "APART")
        for ee, command, a, b, c in states
    ]
    answers = overview(network, [parse_query(text) for text in asked]).answers
    anything, apart = answers[: len(states)], answers[len(states) :]
    assert sum(bool(answer) for answer in anything) > 20
    assert [s for s, x, y in zip(states, anything, apart, strict=True) if x and not y] == []


@pytest.mark.parametrize("count", first_of([2, 3, 4], 2))
def test_a_world_in_which_any_other_reading_is_odd_reaches_the_same_states_of_the_programs(
    count: int,
) -> None:
    """Which of the readings nobody waits for is odd matters only where it is a loss: it need not be remembered."""
    text = load(profile_path()).automata_path.read_text(encoding="utf-8")
    assert text.count(ONE_IS_ENOUGH) == 1
    freer = programs_in_anything(text.replace(ONE_IS_ENOUGH, ANY_OF_THEM), count)
    assert programs_in_anything(text, count) == freer
    # without the losses of the others something is missing: the comparison sees it
    too_few = text.replace(ONE_IS_ENOUGH, "    return j == focus;\n")
    assert programs_in_anything(too_few, count) < freer


CONSTANTS: Mapping[str, Mapping[str, object]] = {
    "one stays after a cancel": {"CANCEL_KEEPS": [True, False], "MIXED": True},
    "what is found active goes": {"START_KEEPS": [False, False]},
    "blown off": {"BLOWS": True, "T_BLOW": [200, 0], "T_GAP": [150, 150], "IL_08_GAP": [50, 50]},
    "one stays after a death": {"DEATH_KEEPS": [False, True], "MIXED": True},
    "all stay after a cancel": {"CANCEL_KEEPS": [True, True]},
    "with evidence of nothing": {"SHOWS_EMPTY": True},
    "released in the order of the grip": {"RELEASE_ORDER": [0, 1]},
}


@pytest.mark.parametrize("changed", first_of(list(CONSTANTS), 3))
def test_so_it_is_with_any_endings(changed: str) -> None:
    text = load(profile_path()).automata_path.read_text(encoding="utf-8")
    freer = programs_in_anything(text.replace(ONE_IS_ENOUGH, ANY_OF_THEM), 2, CONSTANTS[changed])
    assert programs_in_anything(text, 2, CONSTANTS[changed]) == freer


def programs_in_anything(
    text: str, count: int, changed: Mapping[str, object] = MappingProxyType({})
) -> set[tuple[tuple[int, ...], ...]]:
    """All processes but the sensors, and all variables but those of the world, wherever ``ANYTHING`` leads."""
    constants = model_constants(load(profile_path()))
    lists = {name: each[:1] * count for name, each in constants.items() if isinstance(each, list)}
    sized = {"N": count, "RELEASE_ORDER": list(range(count))[::-1], "GRIP_BOUND": 10**6}
    network = make_network(
        read_document(text.encode(), "tool.xml"), constants | lists | sized | dict(changed)
    )
    ends = [each.offset for each in network.variables[1:]] + [None]
    places = {
        each.name: range(len(network.initial.values))[each.offset : end]
        for each, end in zip(network.variables, ends, strict=True)
    }
    world, left_out = places["world"][0], {at for name in OF_THE_WORLD for at in places[name]}
    others = [at for at, process in enumerate(network.processes) if process.name != "Sensors"]
    space = SymbolicSpace(DiscreteSpace(network), Limits(network))
    found = set()
    for node in Search(space).nodes():
        state = node.record.discrete.state
        if state.values[world] == 1:
            values = tuple(value for at, value in enumerate(state.values) if at not in left_out)
            found.add((tuple(state.locations[at] for at in others), values))
    return found
