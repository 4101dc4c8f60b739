"""What is outside of the subset is refused by name and place; nothing is ignored silently."""

import pytest

from end_effector_hal.errors import ModelError
from timed_automata import load_network

CONSTRUCTS = [
    ("struct { clock x; } s;", "", "'x', clock in a structure", "x"),
    ("struct { chan c[2]; } s;", "", "'c', chan[2] in a structure", "c"),
    (
        "struct { int a; } s; void f() { int b = (s = s).a; }",
        "",
        "an assignment of a clock, an array or a structure",
        "s = s",
    ),
    ("struct { int a, b; } s; void f() { s.a = s.a++; }", "", "which changes 's.a' while", "s.a++"),
    (
        "typedef struct { int a, b; } t; t s; int g() { return s.a; } void f() { s.b = g() + s.a++; }",
        "",
        "changes 's.a'",
        "s.a++",
    ),
    (
        "typedef struct { int a; } t; t g() { t r; return r; } t s[2] = {g(), g()};",
        "",
        "a call for a part",
        "g()",
    ),
    ("double d;", "", "'double', a type that is not integral", "double"),
    ("string s;", "", "'string', a type that is not integral", "string"),
    ("int a = 1.5;", "", "'1.5', a floating-point number", "1.5"),
    ("hybrid clock x;", "", "'hybrid', a hybrid clock", "hybrid"),
    ("chan a, b; chan priority a < b;", "", "'priority', a priority", "priority"),
    ('import "lib.so" { int f(); };', "", "'import', an external function", "import"),
    ("dynamic T();", "", "'dynamic', a dynamic template", "dynamic"),
    ("progress { 1; }", "", "'progress', a progress measure", "progress"),
    ("gantt { }", "", "'gantt', a Gantt chart", "gantt"),
    ("before_update { a = 1 }", "", "'before_update', a global update", "before_update"),
    ("void f() { switch (1) { } }", "", "'switch', this statement", "switch"),
    ("int a; void f() { switch (a) { case 1: a = 2; } }", "", "'switch', this statement", "switch"),
    ("void f() { while (true) { break; } }", "", "'break', this statement", "break"),
    ("int guard;", "", "'guard', a word that UPPAAL reserves", "guard"),
    ("int a; void f() { a = atan2(4, 1); }", "", "'atan2', a function on floating-point numbers", "atan2"),
    ("int a; void f() { a = 1 xor 2; }", "", "'xor', this operator", "xor"),
    ("int a; void f() { a = sqrt(4); }", "", "'sqrt', a function on floating-point numbers", "sqrt"),
    ("int f(int x)[2] { }", "", "'[' is not expected here", "["),
    ("typedef int t[2]; t f() { }", "", "a function that returns int[2]", "t f"),
    ("void f(clock x) { }", "", "'x', clock as parameter of a function", "clock"),
    ("void f() { clock x; }", "", "'x', clock in a function", "x;"),
    (
        "void g(int &x) { } void f() { int a; g(a); }",
        "",
        "'a', a scalar of a function passed by reference",
        "a);",
    ),
    ("int a, b; void f() { a = b++ + b; }", "", "'b++', which changes 'b' while", "b++"),
    ("int a; void f() { a = a++; }", "", "'a++', which changes 'a' while", "a++"),
    ("int a, b[2]; void f() { b[a++] = a; }", "", "'b[a++]', which changes 'a' while", "b[a++]"),
    ("int a, b[2]; int g() { return a; } void f() { b[a++] = g(); }", "", "which changes 'a'", "b[a++]"),
    ("int a; bool f() { return exists (i : int[0, 3]) a++ > i; }", "", "inside 'exists'", "exists"),
    ("bool a; int b; void f() { b = a++; }", "", "the value of a bool before", "a++"),
    ("int a, b[2][2], c[2]; void f() { c = b[a++]; }", "", "in the index of a whole array", "b[a++]"),
    ("clock x, y;", "guard x - y < 3", "'x - y < 3', a diagonal constraint", "x - y"),
    ("clock x, y;", "guard x < y", "'x < y', a diagonal constraint", "x < y"),
    ("clock x;", "guard x + 1 < 3", "'x + 1 < 3', arithmetic with a clock", "x + 1"),
    ("clock x;", "guard x != 3", "'x != 3', '!=' on a clock", "x != 3"),
    ("clock x; int a;", "guard a == 1 || x > 3", "a disjunction over clocks", "a == 1"),
    ("clock x; int a;", "guard a == 1 imply x > 3", "a disjunction over clocks", "a == 1"),
    ("clock x;", "guard !(x > 3)", "the negation of a clock constraint", "!(x"),
    ("clock x; int a;", "guard a == 1 ? x > 3 : true", "a clock in '?:'", "a == 1 ?"),
    ("clock x; int a;", "guard a == (a ? x : 2)", "arithmetic with a clock", "a =="),
    ("clock x[2];", "guard exists (i : int[0, 1]) x[i] > 1", "'exists' over clock constraints", "exists"),
    ("clock x;", "guard x", "a clock in an expression over data", "x"),
    ("clock x; bool f(int a) { return a > 1; }", "guard f(x)", "a clock in an expression over data", "f(x)"),
    ("clock x; bool f() { return x > 1; }", "", "the clock 'x' as a number", "x > 1"),
    ("clock x;", "assign x += 1", "'x += 1', this change of a clock", "x += 1"),
    ("clock x;", "assign x++", "'x++', this change of a clock", "x++"),
    ("clock x, y;", "assign x = y", "the clock 'y' as a number", "y"),
    (
        "clock x; urgent chan c;",
        "guard x > 1; sync c!",
        "a clock guard on an edge with an urgent channel",
        "x > 1",
    ),
    ("int a;", "guard P.a == 1", "'P.a', a member", "P.a"),
]


@pytest.mark.parametrize(("declarations", "edge", "message", "place"), CONSTRUCTS)
def test_a_construct_is_refused_by_name(load, pointed, declarations, edge, message, place):
    with pytest.raises(ModelError) as error:
        load(f"{declarations} process P() {{ state A, B; init A; trans A -> B {{ {edge}; }}; }} system P;")
    assert message in str(error.value)
    assert pointed(error.value).startswith(place)


@pytest.mark.parametrize(
    ("invariant", "message"),
    [
        ("x == 3", "'x == 3', an invariant that is an equation with a clock"),
        ("x' == 0", "'x'', the rate of a clock (stopwatch)"),
        ("x <= 3 || a == 1", "a disjunction over clocks"),
        ("x - y <= 3", "a diagonal constraint"),
    ],
)
def test_invariants(load, invariant, message):
    with pytest.raises(ModelError) as error:
        load(f"clock x, y; int a; process P() {{ state A {{ {invariant} }}; init A; }} system P;")
    assert message in str(error.value)


def test_process_priorities(load):
    with pytest.raises(ModelError, match="'<' between processes, a priority"):
        load("process P() { state A; init A; } process Q() { state A; init A; } system P < Q;")


def element(inside="", location="", transition="", template="", queries=""):
    return f"""<nta><declaration>clock x;</declaration>{inside}<template><name>P</name>{template}
        <location id="A">{location}</location><init ref="A"/>
        <transition><source ref="A"/><target ref="A"/>{transition}</transition></template>
        <system>system P;</system>{queries}</nta>"""


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"transition": '<nail x="1" y="2"/><label kind="guard">x</label>'}, "<label> stands behind <nail>"),
        ({"template": '<branchpoint id="B"/>'}, "<location> stands behind <branchpoint> inside <template>"),
        ({"inside": "<lsc><name>L</name></lsc>"}, "a live sequence chart"),
        ({"inside": "<imports>import</imports>"}, "<imports>"),
        (
            {"transition": '<label kind="guarded">x</label>'},
            "A label of kind 'guarded' is unknown here. Did you mean 'guard'?",
        ),
        ({"location": '<label kind="guard">x</label>'}, "A label of kind 'guard' is unknown here"),
        ({"location": "<urgentt/>"}, "<urgentt> is unknown inside <location>. Did you mean 'urgent'?"),
        ({"queries": "<quaries/>"}, "<quaries> is unknown inside <nta>. Did you mean 'queries'?"),
    ],
)
def test_elements_and_labels(tmp_path, parts, message):
    path = tmp_path / "model.xml"
    path.write_text(element(**parts))
    with pytest.raises(ModelError) as error:
        load_network(path)
    assert message in str(error.value)
    assert error.value.where.startswith(f"{path}:")


def test_what_has_no_meaning_is_read(tmp_path):
    path = tmp_path / "model.xml"
    path.write_text(
        element(
            location='<label kind="comments">!!</label><label kind="exponentialrate"> </label>',
            transition='<label kind="comments">x = </label>',
            queries="<queries><option key='a' value='b'/><query><formula/><comment/></query></queries>",
        )
    )
    assert len(load_network(path).processes) == 1
