"""Timed trace inclusion: small networks with known answers, and what a specification must be."""

from __future__ import annotations

import pytest

from tests.unit.timed_automata.explore.models import network
from timed_automata import Network
from timed_automata.errors import ModelError, UsageError
from timed_automata.explore import Explorer
from timed_automata.inclusion import Inclusion, Interface, trace_inclusion

DECLARATIONS = "int[0, 9] shown; bool dim; broadcast chan go, done, late, more; chan push;"
USER = """User: own: clock c;
    w -> w; guard: c >= 2; sync: go!; do: c = 0
    w -> w; guard: c >= 2; sync: push!; do: c = 0, dim = !dim"""
LAMP = {
    "push": "Off -> Off; sync: push?",
    "push when lit": "Lit -> Lit; sync: push?",
    "light": "Off -> Lit; sync: go?; do: u = 0, shown = dim ? 1 : 2",
    "out": "Lit -> Off; guard: u >= 5; sync: done!; do: shown = 0",
}
INTERFACE = Interface(environment=["User"], observed=["shown"], outputs=["done", "late"])


def lamp(edges: dict[str, str] | None = None, invariant: str = "u <= 8", **more: str) -> Network:
    """Lit by `go` for 5 to 8; edges can be replaced, and dropped by an empty text."""
    every = LAMP | (edges or {})
    held = {"Lit": invariant, "Half": "u <= 6"} if invariant else {}
    words = [f"{word}: {text}" for word, text in ({"initial": "Off"} | held | more).items()]
    own = ["Lamp: own: clock u;", "locations: Off Lit", *words, *filter(None, every.values())]
    return network(DECLARATIONS, " | ".join(own), USER)


def compared(implementation: Network, specification: Network | None = None) -> Inclusion:
    return trace_inclusion(implementation, specification or lamp(), INTERFACE)


def test_a_network_does_what_it_does() -> None:
    found = compared(lamp())
    assert found.holds
    assert found.lines == ()


LESS = {
    "a guard that holds later": lamp({"out": LAMP["out"].replace("5", "6")}),
    "an invariant that ends earlier": lamp(invariant="u <= 7"),
    "both": lamp({"out": LAMP["out"].replace("u >= 5", "u > 5 && u < 6")}, invariant="u < 6"),
}
MORE = {
    "a guard that holds earlier": (
        lamp({"out": LAMP["out"].replace("5", "4")}),
        ["6  the implementation does what the specification cannot: done!; shown 2 → 0."],
    ),
    "an invariant that ends later": (
        lamp(invariant="u <= 9"),
        ["the implementation lets time pass; the specification must do something before."],
    ),
    "an invariant that is strict no more": (lamp(invariant=""), ["the implementation lets time pass"]),
    "a missing reset": (
        lamp({"light": LAMP["light"].replace("u = 0, ", "")}),
        ["9  the implementation refuses the input go."],
    ),
    "a clock that is set past the invariant": (
        lamp({"light": LAMP["light"].replace("u = 0", "u = 9")}),
        ["2  the implementation refuses the input go."],
    ),
    "a dropped edge": (lamp({"out": ""}, invariant=""), ["the implementation lets time pass"]),
    "an input that is not heard": (
        lamp({"light": ""}),
        ["2  input go: nothing is seen in the implementation; shown 0 → 2 in the specification."],
    ),
    "swapped outputs": (
        lamp({"out": LAMP["out"].replace("done!", "late!")}),
        ["7  the implementation does what the specification cannot: late!; shown 2 → 0."],
    ),
    "another value": (lamp({"out": LAMP["out"].replace("shown = 0", "shown = 3")}), ["done!; shown 2 → 3."]),
    "what the environment writes, read the other way round": (
        lamp({"light": LAMP["light"].replace("1 : 2", "2 : 1")}),
        ["input go: shown 0 → 1 in the implementation; shown 0 → 2 in the specification."],
    ),
    "a refused input": (lamp({"push": ""}), ["2  the implementation refuses the input push."]),
    "an input that is refused for a while": (
        lamp({"push when lit": "Lit -> Lit; guard: u >= 3; sync: push?"}),
        ["4  the implementation refuses the input push."],
    ),
    "one more thing that it may do": (lamp({"more": "Lit -> Off; guard: u == 5; do: shown = 4"}), ["shown 2 → 4."]),
}  # fmt: skip


@pytest.mark.parametrize("implementation", LESS.values(), ids=LESS)
def test_what_does_less_is_included(implementation: Network) -> None:
    assert compared(implementation).holds
    assert not compared(lamp(), implementation).holds


def test_a_missing_reset_lets_an_output_come_too_early() -> None:
    found = compared(lamp({"light": LAMP["light"].replace("u = 0, ", "")}, invariant=""), lamp(invariant=""))
    assert found.end == 5
    assert found.difference == "the implementation does what the specification cannot: done!; shown 2 → 0."


def test_an_implementation_that_stops_time_does_nothing_more() -> None:
    """It is another fault, which the check of every model finds."""
    stuck = lamp({"out": ""})
    assert compared(stuck).holds
    assert not Explorer(stuck).timelock().holds


def test_the_implementation_may_do_what_nobody_sees() -> None:
    hidden = {
        "out": "Lit -> Half; guard: u >= 4",
        "half": "Half -> Off; guard: u >= 5; sync: done!; do: shown = 0",
        "push while half": "Half -> Half; sync: push?",
    }
    assert compared(lamp(hidden)).holds
    found = compared(lamp(hidden | {"half": hidden["half"].replace("5", "4")}))
    assert "cannot: done!; shown 2 → 0" in found.difference


@pytest.mark.parametrize(("implementation", "told"), MORE.values(), ids=MORE)
def test_what_does_more_is_not_included_and_a_run_shows_it(implementation: Network, told: list[str]) -> None:
    found = compared(implementation)
    assert not found.holds
    assert all(part in found.lines[-1] for part in told), found.lines


def test_the_run_has_its_inputs_with_their_times() -> None:
    found = compared(lamp({"out": LAMP["out"].replace("5", "4")}))
    assert [line.split() for line in found.lines[:-1]] == [["2", "input", "go:", "shown", "0", "→", "2"]]


CHAIN = {"light": "Off -> Begin; sync: go?; do: u = 0, shown = 1", "on": "Begin -> Lit; do: shown = 2"}  # fmt: skip


def test_changes_within_an_instant_are_seen_in_their_order() -> None:
    chain = lamp(CHAIN, committed="Begin")
    assert compared(chain, chain).holds
    assert compared(
        lamp(CHAIN | {"on": "Begin -> Lit; do: shown = 2, u = 0"}, committed="Begin"), chain
    ).holds
    for other in (
        lamp(),
        lamp(CHAIN | {"light": "Off -> Begin; sync: go?; do: u = 0, shown = 3"}, committed="Begin"),
    ):
        assert "input go" in compared(other, chain).lines[-1]


# The specification


def test_a_specification_with_two_ways_on_is_refused_with_its_place() -> None:
    two = lamp({"more": "Lit -> Lost; guard: u >= 7; sync: done!; do: shown = 0"})
    with pytest.raises(
        ModelError, match=r"not deterministic: 'Lamp: Lit -> Off' and 'Lamp: Lit -> Lost'"
    ) as refused:
        compared(lamp(), two)
    assert refused.value.where.startswith("model.xml:")
    apart = lamp({"more": "Lit -> Lost; guard: u >= 7; sync: late!; do: shown = 0"})
    assert compared(lamp(), apart).holds  # they are seen to be different
    assert compared(
        lamp(),
        lamp(
            {
                "out": LAMP["out"].replace("u >= 5", "u >= 5 && u < 7"),
                "more": "Lit -> Off; guard: u >= 7; sync: done!; do: shown = 0, u = 3",
            }
        ),
    ).holds  # and here never both


def test_a_specification_with_a_step_that_nobody_sees_is_refused() -> None:
    hidden = lamp({"more": "Lit -> Lost; guard: u >= 7"})
    with pytest.raises(ModelError, match="The step 'Lamp: Lit -> Lost' has no observed effect"):
        compared(lamp(), hidden)


def test_what_is_not_supported_is_refused() -> None:
    with pytest.raises(ModelError, match="urgent location 'Lit'"):
        compared(lamp(), lamp(urgent="Lit", invariant=""))
    begun = lamp({"begin": "Begin -> Off"}, committed="Begin", initial="Begin")
    with pytest.raises(UsageError, match="specification starts in a committed location"):
        compared(lamp(), begun)
    with pytest.raises(UsageError, match="implementation starts in a committed location"):
        compared(begun, lamp())


def test_both_must_be_able_to_start() -> None:
    for one, other, whose in ((lamp(), "", "specification"), ("", lamp(), "implementation")):
        unlit = " | ".join(["Lamp: own: clock u;", "Off: u > 0", *LAMP.values()])
        never = network(DECLARATIONS, unlit, USER)
        with pytest.raises(UsageError, match=f"An invariant of the {whose} does not hold at its start"):
            compared(one or never, other or never)


def test_what_the_interface_names_must_be_there() -> None:
    with pytest.raises(UsageError, match="no process 'Users'"):
        trace_inclusion(lamp(), lamp(), Interface(environment=["Users"]))
    with pytest.raises(UsageError, match="no variable 'show'"):
        trace_inclusion(lamp(), lamp(), Interface(environment=["User"], observed=["show"]))
    with pytest.raises(UsageError, match="no channel 'don'"):
        trace_inclusion(lamp(), lamp(), Interface(environment=["User"], outputs=["don"]))
    with pytest.raises(
        UsageError, match="'shown' starts as 3 in the implementation and as 0 in the specification"
    ):
        trace_inclusion(lamp(), lamp(), Interface(["User"], ["shown"], start={"shown": 3}))


def test_the_implementation_may_have_other_names_and_begin_by_an_input() -> None:
    own = ["Device: own: clock u;", "Lit: u <= 8", "New -> Off; sync: more?; do: shown = 0", *LAMP.values()]
    device = network(DECLARATIONS.replace("shown;", "shown = 7;"), " | ".join(own))
    interface = Interface(["User"], ["shown"], ["done"], system=["Device"], before=["more"])
    assert trace_inclusion(device, lamp(), interface).holds
    with pytest.raises(UsageError, match="no channel 'adopt'"):
        trace_inclusion(device, lamp(), Interface(["User"], ["shown"], system=["Device"], before=["adopt"]))
