"""Constants and members instead of integers: by how the file itself uses them, never by chance."""

from __future__ import annotations

import pytest

from end_effector_hal.description import profile_path
from tests.unit.timed_automata.explore.models import Template, document
from timed_automata import load_network, make_network, read_document
from timed_automata.explain import Names

CUPS = ("cups", "rod", "cap")


@pytest.fixture(scope="module")
def shipped() -> Names:
    network = load_network(profile_path().with_name("end_effector.xml"))
    return Names(network, CUPS, "actuator", ("cause_at",))


@pytest.mark.parametrize(
    ("variable", "value", "word"),
    [
        ("ee", 3, "GRIPPED"),
        ("ee", 0, "OFF"),
        ("command", -1, "NONE"),
        ("command", 2, "GRIP"),
        ("watched", 4, "CANCEL"),
        ("actuator[1]", 1, "PENDING"),
        ("evidence[0]", 0, "UNKNOWN"),
        ("evidence[2]", 3, "CONFIRMED"),
        ("tool", 1, "LOCKED"),
        ("changer", 3, "UNLOCKING"),
        ("changer", 0, "0"),  # it has constants of two groups: UNCLEAR, of the first, is no value of it
        ("cause", 1, "TIMED_OUT"),
        ("world", 4, "IN_TIME"),
        ("valve[0]", 1, "true"),
        ("Gripper.i", 1, "rod (1)"),
        ("Gripper.i", 3, "3"),
        ("Gripper.k", 1, "1"),  # a place in the release order, no actuator
        ("Gripper.attempt", 2, "2"),
        ("cause_at", 2, "cap (2)"),
        ("cause_at", -1, "-1"),
        ("culprit", 0, "cups (0)"),
    ],
)
def test_values_of_the_shipped_tool(shipped: Names, variable: str, value: int, word: str) -> None:
    assert shipped.value(variable, value) == word


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("evidence[1]", "evidence[rod]"),
        ("Actuator(2)", "Actuator(cap)"),
        ("Wills.spared[0]", "Wills.spared[cups]"),
        ("deactivate[0]", "deactivate[cups]"),
        ("told[1]", "told[1]"),
        ("tool_is[1]", "tool_is[1]"),
        ("Gripper.i", "Gripper.i"),
        ("Gripper", "Gripper"),
    ],
)
def test_elements_of_the_shipped_tool(shipped: Names, name: str, word: str) -> None:
    assert shipped.element(name) == word


def test_a_quantified_name_is_not_that_of_a_variable() -> None:
    declared = "const int A = 0, B = 1; int a[2]; int[0, 1] j; bool all() { return forall (j : int[0, 1]) a[j] == B; }"
    network = make_network(read_document(document(declared, Template("P", ["u -> v"])), "p.xml"))
    names = Names(network, ("x", "y"), "a")
    assert names.value("j", 1) == "1"
    assert names.value("a[0]", 0) == "A"
    assert names.element("a[1]") == "a[y]"
