"""Which edits change nothing that can happen: known answers, and random networks against the naive explorer."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.random_networks import LARGEST, networks
from tests.unit.timed_automata.explore.regions import Region, Regions, Sampled
from timed_automata import Network, make_network
from timed_automata.document import Text
from timed_automata.errors import ModelError, RangeError
from tools.mutants import ReachedNetwork, mutants
from tools.mutants._edited import edited_places

pytestmark = pytest.mark.timeout(3600 if NIGHTLY else 120)

DECLARATIONS = "int[0, 3] told; broadcast chan go, done;"
WORLD = "World: own: clock c; | w -> w; guard: c >= 2; sync: go!; do: c = 0"


def lamp(**changed: str) -> Network:
    """A lamp that is lit for 5 to 6, with one of its texts changed."""
    texts = {
        "lit": "u = 0, n = 2, told = n", "guard": "u >= 5", "invariant": "u <= 6", "out": "told = 0",
        "target": "Off", "more": "",
    } | changed  # fmt: skip
    lamp = f"""Lamp: own: clock u; int[0, 3] n; bool odd; | locations: Off Lit Out | Lit: {texts["invariant"]}
        Off -> Lit; sync: go?; do: {texts["lit"]}
        Lit -> {texts["target"]}; guard: {texts["guard"]}; sync: done!; do: {texts["out"]}
        {texts["more"]}"""
    return network(DECLARATIONS, lamp, WORLD)


SAME = {
    "a condition that always holds there": {"guard": "u >= 5 && n == 2"},
    "a bound that another one implies": {"guard": "u >= 5 && u <= 6"},
    "an edge that is never taken": {"more": "Lit -> Off; guard: u > 6"},
    "an edge that stands twice": {"more": "Lit -> Off; guard: u >= 5; sync: done!; do: told = 0"},
    "the two halves of an edge": {"guard": "u > 5", "more": "Lit -> Off; guard: u == 5; sync: done!; do: told = 0"},
    "a clock that is set before it is asked for": {"out": "told = 0, u = 3"},
    "a variable of its own that is written before it is read": {"out": "told = 0, n = 1"},
    "a variable of its own that nobody reads": {"lit": "u = 0, n = 2, told = n, odd = !odd"},
}  # fmt: skip
OTHER = {
    "a guard that holds later": {"guard": "u >= 6"},
    "a guard that holds at all but one instant": {"guard": "u > 5"},
    "an invariant that lets time pass": {"invariant": "u <= 7"},
    "an invariant that ends earlier": {"invariant": "u < 6"},
    "a clock that is not set": {"lit": "n = 2, told = n"},
    "a clock that is set to something else": {"lit": "u = 1, n = 2, told = n"},
    "a variable that others see": {"out": "told = 1"},
    "a variable of its own that others see later": {"lit": "u = 0, n = 3, told = n"},
    "a guard that holds later, and a variable of its own": {"guard": "u >= 6", "out": "told = 0, n = 1"},
    "another target": {"target": "Out"},
    "one more edge": {"more": "Lit -> Off; guard: u >= 5; do: told = 0"},
}


@pytest.mark.parametrize("changed", SAME.values(), ids=SAME)
def test_an_edit_that_changes_nothing(changed: dict[str, str]) -> None:
    assert ReachedNetwork(lamp(), ["Lamp"]).equivalent(lamp(**changed))


@pytest.mark.parametrize("changed", OTHER.values(), ids=OTHER)
def test_an_edit_that_changes_something(changed: dict[str, str]) -> None:
    assert not ReachedNetwork(lamp(), ["Lamp"]).equivalent(lamp(**changed))


def test_own_variables_are_compared_unless_their_template_is_named() -> None:
    reached = ReachedNetwork(lamp(), [])
    assert reached.equivalent(lamp(guard="u >= 5 && n == 2"))
    assert not reached.equivalent(lamp(out="told = 0, n = 1"))


def test_what_the_own_variable_decides_later_is_seen() -> None:
    """The two states differ in `odd` alone, until it is asked."""
    late = {"more": "Off -> Out; guard: odd"}
    assert not ReachedNetwork(lamp(**late), ["Lamp"]).equivalent(lamp(**late, out="told = 0, odd = true"))


def test_a_network_with_other_variables_is_not_the_same() -> None:
    other = network(DECLARATIONS + "int more;", *([WORLD]))
    assert not ReachedNetwork(lamp(), ["Lamp"]).equivalent(other)


# Random networks


def bisimilar(left: Network, right: Network, largest: int = LARGEST) -> bool:
    """The same steps of locations and values, with the same pauses; any clocks."""
    ours, theirs = Sampled(left, largest), Sampled(right, largest)
    waiting = [(frozenset([ours.initial]), frozenset([theirs.initial]))]
    passed = set(waiting)
    while waiting:
        pair = waiting.pop()
        steps = [_steps(regions, states) for regions, states in zip((ours, theirs), pair, strict=True)]
        if steps[0].keys() != steps[1].keys():
            return False
        for key in steps[0]:
            after = frozenset(steps[0][key]), frozenset(steps[1][key])
            if after not in passed:
                passed.add(after)
                waiting.append(after)
    return True


def _steps(regions: Regions, states: frozenset[Region]) -> dict[object, set[Region]]:
    found: dict[object, set[Region]] = defaultdict(set)
    for state in states:
        for after in regions.actions(state):
            found[after.locations, after.values].add(after)
        later = regions.later(state)
        if later is not None:
            found["time"].add(later)
    return found


@settings(
    max_examples=examples(20, 2000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)
@given(networks(), st.randoms(use_true_random=False))
def test_what_is_shown_to_be_the_same_is_the_same(random_one: Network, random) -> None:  # type: ignore[no-untyped-def]
    note(random_one.document.source.decode().replace("<", "\n<"))
    try:
        reached = ReachedNetwork(random_one, [])
    except (ModelError, RangeError):
        return
    assert reached.equivalent(make_network(random_one.document))
    every = list(mutants(random_one.document))
    for mutant in random.sample(every, min(8, len(every))):
        try:
            edited = make_network(replace(mutant.document))
        except ModelError:
            continue
        if reached.equivalent(edited):
            note(str(mutant))
            assert bisimilar(random_one, edited)


def test_the_reference_tells_what_differs_and_what_does_not() -> None:
    for name, changed in OTHER.items():
        if name != "one more edge":  # it leads where another one leads, and channels have no names here
            assert not bisimilar(lamp(), lamp(**changed), largest=7), name
    read_there_alone = lamp(more="Out -> Out; guard: u > 1")
    nobody_asks = lamp(more="Out -> Out; guard: u > 1; do: u = 0")
    assert bisimilar(read_there_alone, nobody_asks, largest=7)
    texts = "a condition that always holds there", "an edge that stands twice", "the two halves of an edge"
    for name in texts:
        assert bisimilar(lamp(), lamp(**SAME[name]), largest=7), name


def test_with_other_constants_every_state_is_looked_at() -> None:
    """The documents are the same one, and the networks do different things."""
    model = network("const int HIGH = 3; int[0, 9] n;", "Counter: a -> a; guard: n < HIGH; do: n++")
    document, reached = model.document, ReachedNetwork(model, ())
    assert reached.equivalent(make_network(document, {"HIGH": 3}))
    assert not reached.equivalent(make_network(document, {"HIGH": 4}))


def test_only_states_in_which_something_was_edited_are_looked_at() -> None:
    model = lamp()
    reached = ReachedNetwork(model, ["Lamp"])
    for mutant in mutants(model.document, ["Lamp"]):
        try:
            edited = make_network(mutant.document)
        except ModelError:
            continue
        shared = reached.equivalent(edited)
        alone = ReachedNetwork(lamp(), ["Lamp"]).equivalent(edited)  # of a document that shares nothing
        assert shared == alone, mutant
        places = edited_places(model, edited)
        assert (places is None) == (mutant.template == ""), mutant
        if places is None:  # a global declaration may count anywhere
            continue
        assert [each.process for each in places] == [0]
        if mutant.edge is not None:
            assert places[0].locations == {model.processes[0].edges[mutant.edge].source}
        else:  # the location, and those from which an edge leads into it
            (edited_at,) = (at.index for at in model.processes[0].locations if at.drawn.id == mutant.location)
            into = {edge.source for edge in model.processes[0].edges if edge.target == edited_at}
            assert places[0].locations == {edited_at, *into}


COUNTER = "int[0, 9] n; int one() { return 1; } int two() { return 2; }"
NEXT = "int[0, 9] next() { return n < 3 ? n + one() : 0; }"


@pytest.mark.parametrize(
    ("old", "new", "places"),
    [
        ("return 2", "return 3", {1}),
        ("return 1", "return 2", {0}),  # a function that calls it is edited, too
        ("n < 3", "n < 4", {0}),
        ("int[0, 9] n;", "int[0, 9] n = 0;", None),
    ],
)
def test_an_edited_function_counts_where_it_is_called(old: str, new: str, places: set[int] | None) -> None:
    model = network(
        "", f"Counter: own: {COUNTER} {NEXT} | a -> b; do: n = next() | b -> c; guard: two() > 0 | c -> a"
    )
    (template,) = model.document.templates
    text = Text.plain(template.declarations.content.replace(old, new), "edited")
    edited = replace(model.document, templates=(replace(template, declarations=text),))
    found = edited_places(model, make_network(edited))
    assert (None if found is None else {at for each in found for at in each.locations}) == places
