"""The mutants of a file: which there are, each with one edit, and that what commutes is no edit."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.unit.timed_automata.explore.models import Template, document
from timed_automata import make_network, read_document
from timed_automata.errors import ModelError, UsageError
from tools.mutants import Mutant, mutants

DOOR = Template(
    "Door",
    [
        "Shut -> Open; guard: t >= 3 && !locked; sync: push?; do: n++, t = 0",
        "Open -> Shut; guard: t == HOLD; do: t = 0, leave()",
    ],
    declarations="clock t; void leave() { if (n > 2) n = 0; }",
    invariants={"Open": "t <= HOLD"},
)
SOURCE = document(
    "typedef int[0, 99] ms_t; const ms_t HOLD = 9; int[0, 5] n; bool locked; chan push, knock;",
    DOOR,
    Template("World", ["w -> w; sync: push!", "w -> v; sync: knock!"]),
)


def found(*templates: str) -> list[Mutant]:
    return list(mutants(read_document(SOURCE, "door.xml"), templates or None))


def told(mutant: Mutant) -> str:
    return f"{mutant.element}: {mutant.operator}, {mutant.old} -> {mutant.new}"


def test_each_part_is_edited() -> None:
    every = [told(mutant) for mutant in found("Door")]
    assert every == [
        "declaration of HOLD: constant, 9 -> 10",
        "declaration of HOLD: constant, 9 -> 8",
        "declaration of n: constant,  -> = 1",
        "declaration of locked: constant,  -> = true",
        "function leave: assignment dropped, if (n > 2) n = 0; -> ;",
        "function leave: condition dropped, n > 2 -> true",
        "function leave: comparison, > -> >=",
        "function leave: comparison, > -> <=",
        "function leave: constant, 2 -> 3",
        "function leave: constant, 2 -> 1",
        "function leave: assignment dropped, n = 0; -> ;",
        "function leave: constant, 0 -> 1",
        "function leave: constant, 0 -> -1",
        "location Shut: committed, ordinary -> committed",
        "location Shut: urgent, ordinary -> urgent",
        "invariant of Open: condition dropped, t <= HOLD -> true",
        "invariant of Open: comparison, <= -> <",
        "invariant of Open: comparison, <= -> >",
        "invariant of Open: constant, HOLD -> (HOLD + 1)",
        "invariant of Open: constant, HOLD -> (HOLD - 1)",
        "location Open: committed, ordinary -> committed",
        "location Open: urgent, ordinary -> urgent",
        "Shut -> Open: edge deleted, Shut -> Open -> ",
        "Shut -> Open: target, Shut -> Open -> Shut -> Shut",
        "Shut -> Open, guard: condition dropped, t >= 3 && !locked -> true",
        "Shut -> Open, guard: connective, && -> ||",
        "Shut -> Open, guard: condition dropped, t >= 3 && !locked -> !locked",
        "Shut -> Open, guard: condition dropped, t >= 3 && !locked -> t >= 3",
        "Shut -> Open, guard: comparison, >= -> >",
        "Shut -> Open, guard: comparison, >= -> <",
        "Shut -> Open, guard: constant, 3 -> 4",
        "Shut -> Open, guard: constant, 3 -> 2",
        "Shut -> Open, guard: negation, !locked -> (locked)",
        "Shut -> Open, synchronisation: synchronisation, push? -> ",
        "Shut -> Open, synchronisation: synchronisation, push? -> push!",
        "Shut -> Open, assignment: assignment dropped, n++, t = 0 -> t = 0",
        "Shut -> Open, assignment: constant, ++ -> --",
        "Shut -> Open, assignment: assignment dropped, n++, t = 0 -> n++",
        "Shut -> Open, assignment: constant, 0 -> 1",
        "Shut -> Open, assignment: constant, 0 -> -1",
        "Open -> Shut: edge deleted, Open -> Shut -> ",
        "Open -> Shut: target, Open -> Shut -> Open -> Open",
        "Open -> Shut, guard: condition dropped, t == HOLD -> true",
        "Open -> Shut, guard: comparison, == -> !=",
        "Open -> Shut, guard: constant, HOLD -> (HOLD + 1)",
        "Open -> Shut, guard: constant, HOLD -> (HOLD - 1)",
        "Open -> Shut, assignment: assignment dropped, t = 0, leave() -> leave()",
        "Open -> Shut, assignment: constant, 0 -> 1",
        "Open -> Shut, assignment: constant, 0 -> -1",
        "Open -> Shut, assignment: assignment dropped, t = 0, leave() -> t = 0",
    ]


def test_a_channel_becomes_another_one_of_the_same_direction() -> None:
    edits = [told(mutant) for mutant in found("World") if mutant.operator == "synchronisation"]
    assert "w -> w, synchronisation: synchronisation, push -> knock" in edits
    assert "w -> v, synchronisation: synchronisation, knock -> push" in edits


def test_all_templates_without_a_name_each_in_its_own_and_what_is_global() -> None:
    assert Counter(mutant.template for mutant in found()) == {"": 4, "Door": 46, "World": 14}


def test_an_edit_changes_its_template_or_the_declarations_alone_and_most_are_models() -> None:
    true = read_document(SOURCE, "door.xml")
    valid = 0
    for mutant in mutants(true, ["Door"]):
        assert mutant.document.templates[1] is true.templates[1]
        shared = mutant.document.declarations is true.declarations
        assert shared == (mutant.template == "Door")
        assert (mutant.document.templates[0] is true.templates[0]) == (mutant.template == "")
        try:
            make_network(mutant.document)
        except ModelError:
            continue
        valid += 1
    assert valid == 48  # the others have clocks in a disjunction


@pytest.mark.parametrize(
    ("updates", "swaps"),
    [("n = 1, m = 2", 0), ("n = 1, m = n", 1), ("m = n, n = 1", 1), ("n = 1, n = 2", 1), ("n = 1, set()", 1)],
)
def test_two_assignments_are_swapped_where_their_order_means_something(updates: str, swaps: int) -> None:
    source = document("int n, m; void set() { m = n; }", Template("P", [f"a -> b; do: {updates}"]))
    edits = [each.operator for each in mutants(read_document(source, "p.xml"))]
    assert edits.count("assignments swapped") == swaps


def test_an_unknown_template_is_named() -> None:
    with pytest.raises(UsageError, match=r"no template 'Dor'.*Did you mean 'Door'"):
        found("Dor")
