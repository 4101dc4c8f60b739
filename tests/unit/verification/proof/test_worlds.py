"""What the worlds of the shipped model leave out changes no state of the programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from types import MappingProxyType

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from tests.support.nightly import NIGHTLY, first_of
from timed_automata import Network, load_network, make_network, read_document
from timed_automata.explore import overview
from timed_automata.explore.search import Search
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits
from timed_automata.network import State
from timed_automata.queries import parse_query

pytestmark = pytest.mark.thinned  # long

ONE_IS_ENOUGH = (
    "    if (j == focus || j == witness() || any_odd() || homed(j)) return j == focus || odd == -1 || odd == j;\n"
    "    return level == PARTIAL ? odd == -1 &amp;&amp; usual(j) == CONFIRMED &amp;&amp; may_lose()"
    " : odd == j &amp;&amp; level == usual(j);\n"
)
ANY_OF_THEM = "    return j == focus || odd == -1 || odd == j;\n"
IT_SETTLES = "    return ee == RELEASING &amp;&amp; !any_odd()"
NEVER = "    return false &amp;&amp; !any_odd()"
GONE_LATER = (
    "    return level == evidence[j] || odd == -1 || odd == j || any_odd() || ee != RELEASING"
    " || N &lt;= 4 &amp;&amp; !valve[odd];\n"
)
GONE_AT_ONCE = "    return true;\n"
OF_MANY_STEPS = "OVER_AT_ONCE = N > 4;"
OF_THE_WORLD = (
    "evidence", "vented", "parked", "supply_ok", "Sensors.focus", "Sensors.odd", "Sensors.emptied",
)  # fmt: skip
OF_GRIP = (
    "evidence", "ee", "command", "actuator", "valve", "kept", "blow", "cause", "cause_at", "adopted",
    "dropped",
)  # fmt: skip
"""What Gripper sees, tells and asks for; nobody hears a dead one."""
UNMOVED = ("Changer", "Arming", "World", "Arbiter", "UnlockLine", "Tool", "Listener", "Patience", "Wills")
ACTIVE = ("Pending", "Confirming", "On", "Losing")
GRIP_ERROR, RELEASING, PENDING, ON = 2, 4, 1, 2


def test_loose_tool_reaches_every_state_of_grip_that_anything_reaches() -> None:
    """A will is computed from these: so deaths in LOOSE_TOOL are deaths in every state."""
    description = load(profile_path())
    network = load_network(description.automata_path, model_constants(description))
    states = list(product(range(7), (-1, 2, 3, 4), (0, 1), (0, 1), (0, 1)))
    asked = [
        f"E<> world == {world} && ee == {ee} && command == {command}"
        f" && valve[0] == {a} && valve[1] == {b} && valve[2] == {c} && world > 0"
        for world in ("ANYTHING", "LOOSE_TOOL")
        for ee, command, a, b, c in states
    ]
    answers = overview(network, [parse_query(text) for text in asked]).answers
    anything, apart = answers[: len(states)], answers[len(states) :]
    assert sum(bool(answer) for answer in anything) > 20
    assert [s for s, x, y in zip(states, anything, apart, strict=True) if x and not y] == []


@pytest.mark.parametrize("count", first_of([2, 3, 4] if NIGHTLY else [2, 3], thinned=0))
def test_a_world_in_which_any_other_reading_is_odd_reaches_the_same_states_of_the_programs(
    count: int,
) -> None:
    """Which of the readings nobody waits for is odd matters only where it is a loss, and while that is asked for."""
    text = shipped()
    assert programs_in_anything(text, count) == programs_in_anything(freer(text), count)
    # without the losses of the others something is missing: the comparison sees it
    too_few = text.replace(ONE_IS_ENOUGH, "    return j == focus;\n")
    assert programs_in_anything(too_few, count) < programs_in_anything(text, count)


def shipped() -> str:
    """The shipped automata."""
    return load(profile_path()).automata_path.read_text(encoding="utf-8")


def freer(text: str) -> str:
    """The automata without what ANYTHING leaves out of the readings that nobody waits for."""
    for old, new in ((ONE_IS_ENOUGH, ANY_OF_THEM), (IT_SETTLES, NEVER), (GONE_LATER, GONE_AT_ONCE)):
        assert text.count(old) == 1
        text = text.replace(old, new)
    return text


CONSTANTS: Mapping[str, Mapping[str, object]] = {
    "blown off": {"BLOWS": True, "T_BLOW": [200, 0], "T_GAP": [150, 150], "IL_08_GAP": [50, 50]},
    "what is found active goes": {"START_KEEPS": [False, False]},
    "one stays after a cancel": {"CANCEL_KEEPS": [True, False], "MIXED": True},
    "one stays after a death": {"DEATH_KEEPS": [False, True], "MIXED": True},
    "all stay after a cancel": {"CANCEL_KEEPS": [True, True]},
    "with evidence of nothing": {"SHOWS_EMPTY": True},
    "released in the order of the grip": {"RELEASE_ORDER": [0, 1]},
}


@pytest.mark.parametrize("changed", first_of(CONSTANTS, thinned=0))
def test_so_it_is_with_any_endings(changed: str) -> None:
    text = shipped()
    expected = programs_in_anything(freer(text), 2, CONSTANTS[changed])
    assert programs_in_anything(text, 2, CONSTANTS[changed]) == expected


@pytest.mark.parametrize("changed", first_of(["", *CONSTANTS], thinned=0))
def test_a_grip_that_has_died_may_as_well_be_over_at_once(changed: str) -> None:
    """Nobody hears it: the lines and the last will are where they are if it goes on at its own pace."""
    text, constants = shipped(), CONSTANTS.get(changed, {})
    assert text.count(OF_MANY_STEPS) == 1
    over = text.replace(OF_MANY_STEPS, "OVER_AT_ONCE = true;")
    goes_on = surroundings_of_the_dead(text, constants)
    assert len(goes_on) > 50
    assert surroundings_of_the_dead(over, constants) == goes_on


def programs_in_anything(
    text: str, count: int, changed: Mapping[str, object] = MappingProxyType({})
) -> set[object]:
    """All processes but the sensors, and all variables but those of the world, wherever ``ANYTHING`` leads.

    While a release runs or GRIP_ERROR is latched nobody asks whether an active actuator is PENDING or ON.
    """
    network = of_size(text, count, changed)
    at, others = places(network), [n for n, each in enumerate(network.processes) if each.name != "Sensors"]
    left_out = {offset for name in OF_THE_WORLD for offset in at[name]}
    ee, actuators = at["ee"][0], set(at["actuator"])
    names = [[location.name for location in process.locations] for process in network.processes]
    found: set[object] = set()
    for state in reached(network, at["world"][0], 1):
        unasked = state.values[ee] in (GRIP_ERROR, RELEASING)
        values = tuple(
            ON if unasked and n in actuators and value == PENDING else value
            for n, value in enumerate(state.values)
            if n not in left_out
        )
        where = [names[n][state.locations[n]] for n in others]
        found.add((tuple("On" if unasked and name in ACTIVE else name for name in where), values))
    return found


def surroundings_of_the_dead(text: str, changed: Mapping[str, object]) -> set[object]:
    """Everything but Grip and what it sees and asks for, wherever it has died."""
    network = of_size(text, 2, changed)
    at = places(network)
    kept = [n for n, each in enumerate(network.processes) if each.name in UNMOVED]
    of_grip = {offset for name in OF_GRIP for offset in at[name]}
    left_out = of_grip | {n for name in at if name.startswith(("Gripper.", "Sensors.")) for n in at[name]}
    dead = at["dead"][0]
    return {
        (
            tuple(state.locations[n] for n in kept),
            tuple(value for n, value in enumerate(state.values) if n not in left_out),
        )
        for state in reached(network, at["world"][0], 3)
        if state.values[dead]
    }


def of_size(text: str, count: int, changed: Mapping[str, object]) -> Network:
    """The shipped tool with so many steps, all like its first."""
    constants = model_constants(load(profile_path()))
    lists = {
        name: [row[:1] * count for row in each] if isinstance(each[0], list) else each[:1] * count
        for name, each in constants.items()
        if isinstance(each, list)
    }
    sized = {"N": count, "RELEASE_ORDER": list(range(count))[::-1], "GRIP_BOUND": 10**6}
    document = read_document(text.encode(), "tool.xml")
    return make_network(document, constants | lists | sized | dict(changed))


def places(network: Network) -> dict[str, range]:
    """Where the values of each variable stand in a state."""
    ends = [each.offset for each in network.variables[1:]] + [len(network.initial.values)]
    return {each.name: range(each.offset, end) for each, end in zip(network.variables, ends, strict=True)}


def reached(network: Network, world: int, number: int) -> Iterator[State]:
    """All discrete states in a world."""
    for node in Search(SymbolicSpace(DiscreteSpace(network), Limits(network))).nodes():
        if (state := node.record.discrete.state).values[world] == number:
            yield state
