"""Constructs of models that others have published: they load unchanged, and mean what they mean in UPPAAL."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from tests.unit.timed_automata.explore.models import load
from tests.unit.timed_automata.simulate.run_facts import assert_is_run
from timed_automata import (
    Execution,
    Network,
    Step,
    TakenEdge,
    load_document,
    load_network,
    make_network,
    read_document,
)
from timed_automata.errors import ModelError
from timed_automata.explore import Explorer, overview
from timed_automata.monitor import Monitor
from timed_automata.simulate import simulate

CROSSING = Path(__file__).parent / "models/crossing.xml"


def network(declarations: str, update: str) -> Network:
    return make_network(
        read_document(
            f"""<nta><declaration>int[0,9] a, b, c; int n; int list[5]; clock x; {declarations}</declaration>
            <template><name>P</name><location id="s"/><location id="e"/><init ref="s"/>
            <transition><source ref="s"/><target ref="e"/><label kind="assignment">{update}</label></transition>
            </template><system>system P;</system></nta>""".encode(),
            "m.xml",
        )
    )


def after(declarations: str, update: str) -> dict[str, int]:
    """What is not zero after one update."""
    made = network(declarations, update)
    values, resets = list(made.initial.values), []
    (edge,) = made.processes[0].edges
    assert edge.update is not None
    edge.update(values, resets)
    return {name: values[at] for name, at in made.offsets.items() if values[at]}


@pytest.mark.parametrize(
    ("declarations", "update", "left"),
    [
        ("void put(int e) { list[n++] = e; }", "put(7), put(9)", {"n": 2, "list[0]": 7, "list[1]": 9}),
        ("", "a = b = 3", {"a": 3, "b": 3}),
        ("", "a = b++, c = ++b", {"b": 2, "c": 2}),
        ("", "list[n++] += 5", {"n": 1, "list[0]": 5}),
        ("", "a += b += 2", {"a": 2, "b": 2}),
        ("", "a = b++ > 0 &amp;&amp; c++ > 0", {"b": 1}),
        ("", "a = b++ == 0 || c++ > 0", {"a": 1, "b": 1}),
        ("void f() { int i = 0; while (i++ &lt; 3) list[i] += i; }", "f()", {"list[1]": 1, "list[2]": 2, "list[3]": 3}),
        ("void f() { int i = 5; int j; j = i--; a = i; b = j; }", "f()", {"a": 4, "b": 5}),
        ("void f() { int k[2]; int i; k[i++] = 4; k[i++] = 5; a = k[0]; b = k[1]; }", "f()", {"a": 4, "b": 5}),
        ("void f() { if (a = 1) b = 2; }", "f()", {"a": 1, "b": 2}),
        ("int f() { return n++; }", "a = f() + 1, b = n", {"a": 1, "b": 1, "n": 1}),
    ],
)  # fmt: skip
def test_an_assignment_inside_an_expression(declarations: str, update: str, left: dict[str, int]) -> None:
    assert after(declarations, update) == left


def test_an_update_with_a_counting_index_sets_its_clock_all_the_same() -> None:
    (edge,) = network("", "x = 0, list[n++] = 1").processes[0].edges
    assert edge.resets == frozenset({1})


def test_a_crossing_with_a_queue() -> None:
    made = load_network(CROSSING)
    (note,) = made.document.notes
    assert str(note).startswith(f"{CROSSING}:")
    assert "rate is ignored" in note.what
    explorer = Explorer(made)
    for query in made.document.queries:
        assert explorer.check(query.formula.content).holds, query.formula.content
    assert not explorer.check("A[] forall (i : id_t) not Train(i).Stop").holds
    assert not explorer.check("E<> shared == 1").holds


BRANCHES = """<nta><declaration>int k; chan go;</declaration><template><name>P</name>
<location id="s"><name>S</name></location><location id="a"><name>A</name></location>
<location id="b"><name>B</name></location><branchpoint id="p" x="5" y="6"/><init ref="s"/>
<transition><source ref="s"/><target ref="p"/><label kind="select">i : int[1, 2]</label>
<label kind="guard">k == 0</label>{first}<nail x="1" y="2"/></transition>
<transition><source ref="p"/><target ref="a"/><label kind="probability">3</label>
<label kind="assignment">k = i</label></transition>
<transition><source ref="p"/><target ref="b"/>{second}<nail x="3" y="4"/></transition>
</template><system>system P;</system></nta>"""


def branches(first: str = "", second: str = "") -> Network:
    return make_network(read_document(BRANCHES.format(first=first, second=second).encode(), "m.xml"))


def test_every_way_through_a_branch_point_is_an_edge() -> None:
    made = branches()
    explorer = Explorer(made)
    for reached in ("P.A && k == 1", "P.A && k == 2", "P.B && k == 0"):
        assert explorer.check(f"E<> {reached}").holds, reached
    assert explorer.check("A[] P.B imply k == 0").holds
    drawn = made.document.templates[0].edges
    assert [[(nail.x, nail.y) for nail in edge.nails] for edge in drawn] == [
        [(1, 2), (5, 6)],
        [(1, 2), (5, 6), (3, 4)],
    ]
    assert ["weight" in note.what for note in made.document.notes] == [True]


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        ('<label kind="assignment">k = 1</label>', "", "Join the two there."),
        ("", '<label kind="guard">k == 1</label>',
         "A branch has a guard. Move it to the edge before the branch point."),
    ],
)  # fmt: skip
def test_a_branch_point_that_says_two_things_is_refused(first: str, second: str, said: str) -> None:
    with pytest.raises(Exception, match=said):
        branches(first, second)


LOWER = """clock x, y; int[0,3] v = 2; chan set_x;
process P() {{
  state A, B {{ {invariant} }}, C;
  init A;
  trans A -> B {{ {edge} }}, B -> B {{ sync set_x?; assign x = 0; }}, B -> C {{ assign v = 3; }};
}}
process Q() {{ state D; init D; trans D -> D {{ sync set_x!; }}; }}
system P, Q;"""


@pytest.mark.parametrize(
    ("invariant", "edge", "first", "last"),
    [
        ("x >= 3", "", 3, None),  # entered no sooner
        ("x > v", "", 2, None),
        ("x >= 3 && y <= 5", "", 3, 5),
        ("3 <= x && x <= 4", "assign x = 3;", 0, None),  # the value after the update counts
    ],
)
def test_a_lower_bound_in_an_invariant(invariant: str, edge: str, first: int, last: int | None) -> None:
    explorer = Explorer(load(LOWER.format(invariant=invariant, edge=edge)))
    for query, holds in (
        ("E<> P.B", True),
        (f"A[] P.B imply y >= {first}", True),
        (f"A[] P.B imply y > {first}", "v" in invariant),
        ("A[] P.B imply x >= 2", True),
        (f"A[] P.B imply y <= {last or 0}", last is not None),
        ("E<> P.C", True),
    ):
        verdict = explorer.check(query)
        assert verdict.holds is holds, query
    trace = explorer.check("E<> P.B").trace
    assert trace.steps[0].at >= first


def test_what_would_break_a_lower_bound_is_not_taken() -> None:
    """Elsewhere a clock is set, or a variable counts on: while the location is left, it is not possible."""
    text = """clock x; int[0,4] v;
    process P() {{ state A, B {{ x >= v }}; init A; trans A -> B {{ guard x >= 2; }}; }}
    process Q() {{ state D; init D; trans D -> D {{ assign {what}; }}; }}
    system P, Q;"""
    setting = Explorer(load(text.format(what="x = 0, v = 1")))
    assert setting.check("A[] P.B imply x >= v").holds
    counting = Explorer(load(text.format(what="v = v < 4 ? v + 1 : v")))
    assert counting.check("A[] P.B imply x >= v").holds
    assert counting.check("E<> P.B && v == 4").holds
    assert counting.check("A[] P.B && v == 4 imply x >= 4").holds
    assert not counting.check("A[] P.B && v == 4 imply x > 4").holds


def test_where_no_invariant_lets_a_run_begin() -> None:
    made = load("clock x; process P() { state A { x >= 1 }; init A; } system P;")
    with pytest.raises(ModelError, match="The invariant 'x >= 1' does not hold in the initial state"):
        Explorer(made).check("A[] P.A")
    with pytest.raises(ModelError, match="The initial state violates an invariant"):
        simulate(made, Random(1))
    monitor = Monitor(made)
    monitor.begin(0)
    assert [each.what for each in monitor.objections] == ["An invariant does not hold in the initial state."]


def test_a_lower_bound_stops_no_time() -> None:
    """Where nothing else can happen, time passes for ever; with an upper bound it stands still."""
    for invariant, holds in (("x >= 1", True), ("x >= 1 && x <= 2", False)):
        made = load(
            f"clock x; process P() {{ state A, B {{ {invariant} }}; init A; trans A -> B {{ }}; }} system P;"
        )
        explorer = Explorer(made)
        assert explorer.timelock().holds is holds
        assert overview(made, []).stopped is not holds
        assert explorer.check("sup{P.B}: x").extremes[0].value == (None if holds else 2)
        assert explorer.check("inf{P.B}: x").extremes[0].value == 1


@pytest.mark.parametrize(("invariant", "holds"), [("x >= 1", True), ("x >= 0", False), ("y >= 1", False)])
def test_a_lower_bound_takes_time_on_a_cycle_that_sets_its_clock(invariant: str, holds: bool) -> None:
    made = load(
        f"""clock x, y; process P() {{ state A, B {{ {invariant} }}; init A;
        trans A -> B {{ }}, B -> A {{ assign x = 0; }}; }} system P;"""
    )
    assert Explorer(made).zeno().holds is holds
    assert overview(made, []).zeno is not holds


def test_a_run_with_lower_bounds_is_simulated_and_judged() -> None:
    made = load(
        """clock x; process P() { state A, B { x >= 3 && x <= 4 }; init A;
        trans A -> B { }, B -> A { assign x = 0; }; } system P;"""
    )
    for seed in range(20):
        trace = simulate(made, Random(seed), steps=20).trace
        assert len(trace.steps) == 20
        assert_is_run(trace)
    first = trace.steps[0]
    monitor = Monitor(made)
    monitor.begin(0)
    edge = first.edges[0]
    taken = TakenEdge("P", "A", "B", edge.index, "")
    monitor.observe(Step(2_999, None, 0, False, None, None, (taken,), ()))
    assert [each.what for each in monitor.objections] == ["P A → B was taken before its time."]


def test_a_lower_bound_is_not_executed() -> None:
    made = load(LOWER.format(invariant="x >= 3", edge=""))
    with pytest.raises(
        ModelError, match="'x >= 3' cannot be executed: an event cannot wait for a lower bound"
    ):
        Execution(made, ["P", "Q"])


@pytest.mark.parametrize("second", ['<location id="a"/>', '<branchpoint id="a"/>'])
def test_an_id_that_stands_twice_in_a_template_is_refused(second: str) -> None:
    template = f'<template><name>P</name><location id="a"/>{second}<init ref="a"/></template>'
    with pytest.raises(ModelError, match=r"A second location has the id 'a'; .* at m\.xml:1:30\.") as error:
        read_document(f"<nta>{template}<system>system P;</system></nta>".encode(), "m.xml")
    assert error.value.where == "m.xml:1:48"


def test_an_id_may_stand_in_two_templates() -> None:
    template = """<template><name>{0}</name><location id="a"><name>{0}a</name></location>
    <location id="b"><name>{0}b</name></location><init ref="b"/>
    <transition><source ref="b"/><target ref="a"/></transition></template>"""
    text = f"<nta>{template.format('P')}{template.format('Q')}<system>system P, Q;</system></nta>"
    explorer = Explorer(make_network(read_document(text.encode(), "m.xml")))
    assert explorer.check("E<> P.Pa && Q.Qb").holds
    assert explorer.check("E<> Q.Qa && P.Pb").holds


def test_test_code_is_ignored_with_a_note() -> None:
    text = """<nta><template><name>P</name><location id="a"><label kind="testcodeEnter">x();</label></location>
    <init ref="a"/></template><system>system P;</system></nta>"""
    (note,) = read_document(text.encode(), "m.xml").notes
    assert note.what == "The test code is ignored."


def test_the_files_of_this_product_have_no_notes() -> None:
    package = Path(load_document.__code__.co_filename).parents[2] / "end_effector_hal"
    files = [file for file in sorted(package.rglob("*.xml")) if b"<nta" in file.read_bytes()]
    assert len(files) >= 2
    for file in files:
        assert load_document(file).notes == (), file
