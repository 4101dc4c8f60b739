"""Every mistake, and what is outside of the subset, is refused by name and place, with what is likely meant."""

import re

import pytest

from end_effector_hal.errors import ModelError
from tests.unit.timed_automata.explore.models import load, pointed
from timed_automata import load_network, make_network, read_document

# Each mistake is reported at its place, with what is wrong and what is likely meant.


# declarations, labels of an edge, what is said, what the place points at
MISTAKES = [
    ("int a = ;", "", "';' is not expected here. Expected", ";"),
    ("int a", "", "The text ends too early. Expected", ""),
    ("int a b;", "", "'b' is not expected here", "b;"),
    ("int if = 1;", "", "'if' is not expected here. Expected '[' or a name", "if"),
    ("int a = 3 $ 4;", "", "'$' is no part of the language", "$"),
    ("int a; /* no end", "", "This comment does not end. Expected '*/'", "/* no"),
    ("int f() { return 1 }", "", "'}' is not expected here. Expected", "}"),
    ("int a; int a;", "", "'a' is declared twice", "a;"),
    ("int a = b;", "", "'b' is not declared", "b;"),
    ("int evidence; int a = evidenc;", "", "'evidenc' is not declared. Did you mean 'evidence'?", "evidenc;"),
    ("typedef int[0, 3] id_t; id_d a;", "", "'id_d' is no type. Did you mean 'id_t'?", "id_d"),
    ("int b; int a = b;", "", "must be constant; 'b' depends on b", "b;"),
    ("int b; int a[b];", "", "The size of an array must be constant", "b]"),
    ("int a[0];", "", "The size of an array is 0", "0]"),
    ("int[3, 2] a;", "", "'int[3, 2]' is empty", "int[3"),
    ("int[0, 3] a = 4;", "", "a = 4 is out of its range [0,3]", "4;"),
    ("int a[2] = {1, 2, 3};", "", "'a' needs 2 values, not 3", "{1"),
    ("int a[2] = 1;", "", "'a' is an array of 2", "1;"),
    ("int a = {1};", "", "Braces where 'a' has a single value", "{1"),
    ("const int N;", "", "The constant 'N' has no value", "N;"),
    ("chan c = 1;", "", "A chan has no initialiser", "c ="),
    ("broadcast int a;", "", "'broadcast' belongs to channels, not to int", "broadcast"),
    ("const clock x;", "", "'const' belongs to int and bool, not to clock", "const"),
    ("void a;", "", "'a' cannot be void", "a;"),
    ("int f(int x) { return x; } const int N = f();", "", "'f' takes 1 arguments, not 0", "f();"),
    ("void f() { return 1; }", "", "A void function returns no value", "return"),
    ("int f() { return; }", "", "A value of type int is expected after 'return'", "return"),
    ("int f() { return f(); }", "", "'f' is not declared", "f();"),
    ("const int N = 1; void f() { N = 2; }", "", "'N' is constant and cannot be assigned", "N = 2"),
    ("void f(const int x) { x++; }", "", "'x' is constant and cannot be assigned", "x++"),
    ("void f() { int a[2] = {1}; }", "", "'a' needs 2 values, not 1", "{1"),
    ("void f(int &x) { x = 1; } const int N = 2; void g() { f(N); }", "", "'N' is a number", "N);"),
    ("void f(int &x) { x = 1; } int[0, 3] a; void g() { f(a); }", "", "'a' is int[0,3]", "a);"),
    ("int a;", "guard a = 1", "an assignment inside an expression", "a = 1"),
    ("int a;", "guard a +", "The text ends too early. Expected an expression", "</label>"),
    ("int a;", "guard a 1", "'1' is not expected here. Expected '=', an operator or the end", "1"),
    ("int a[2];", "guard a == 1", "'a' is an array", "a == 1"),
    ("int a[2];", "guard a[2] == 1", "Index 2 of 'a' is outside of 0 to 1", "2]"),
    ("int a;", "guard a[0] == 1", "'a' is no array", "a[0]"),
    ("chan c;", "guard c == 1", "'c' is a channel", "c =="),
    ("typedef int t;", "guard t == 1", "'t' is a type", "t =="),
    ("int f() { return 1; }", "guard f == 1", "'f' is a function", "f =="),
    ("int a;", "guard a(1) == 1", "'a' is not a function", "a(1)"),
    ("void f() { }", "guard f() == 1", "'f' returns nothing", "f()"),
    ("int a; int f() { a = 1; return a; }", "guard f() == 1", "The guard 'f() == 1' changes a", "f()"),
    ("clock x[2];", "guard x > 1", "'x' is an array of clocks", "x >"),
    ("int a;", "sync a!", "'a' is no channel", "a!"),
    ("chan c[2];", "sync c!", "'c' is an array of channels", "c!"),
    ("chan c;", "sync c", "The text ends too early. Expected '!' or '?'", "</label>"),
    ("chan c;", "sync d!", "'d' is not declared", "d!"),
    ("int a;", "assign a == 1", "'a == 1' has no effect. Did you mean '='?", "a == 1"),
    ("int a;", "assign 3 = a", "'3' cannot be assigned. Expected a variable", "3 ="),
    ("const int N = 1;", "assign N = 2", "'N' is constant and cannot be assigned", "N = 2"),
    ("const int N[2] = {1, 2};", "assign N[0] = 2", "'N' is constant and cannot be assigned", "N[0]"),
    ("int[0, 3] a;", "assign a = 4", "a = 4 is out of its range [0,3]", "a = 4"),
    ("chan c;", "assign c = 1", "'c' is a channel and cannot be assigned", "c = 1"),
    ("int a[2], b[3];", "assign a = b", "'a' is int[2]", "a = b"),
    ("int a;", "select i : int[0, 1]; assign i = 1", "'i' is constant and cannot be assigned", "i = 1"),
    ("int a;", "select i : int; assign a = i", "'int' is no bounded type", "int"),
    ("int a;", "select i : int[0, 1], i : int[0, 1]", "'i' is declared twice", "i :"),
    ("int a;", "select i : int[0, 20000]", "More than 10000 values are selected", "i :"),
    ("int a; clock x;", "assign a = x", "the clock 'x' as a number", "x"),
    ("int a;", "guard forall (i : 3) a == i", "'3' is not expected here. Expected a name or a type", "3)"),
]  # fmt: skip

OUTSIDE = [
    ("struct { clock x; } s;", "", "'x', clock in a structure", "x"),
    ("struct { chan c[2]; } s;", "", "'c', chan[2] in a structure", "c"),
    ("struct { int a; } s; void f() { int b = (s = s).a; }", "",
     "an assignment of a clock, an array or a structure", "s = s"),
    ("struct { int a, b; } s; void f() { s.a = s.a++; }", "", "which changes 's.a' while", "s.a++"),
    ("typedef struct { int a, b; } t; t s; int g() { return s.a; } void f() { s.b = g() + s.a++; }", "",
     "changes 's.a'", "s.a++"),
    ("typedef struct { int a; } t; t g() { t r; return r; } t s[2] = {g(), g()};", "", "a call for a part", "g()"),
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
    ("void g(int &x) { } void f() { int a; g(a); }", "", "'a', a scalar of a function passed by reference", "a);"),
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
    ("clock x; urgent chan c;", "guard x > 1; sync c!", "a clock guard on an edge with an urgent channel", "x > 1"),
    ("int a;", "guard P.a == 1", "'P.a', a member", "P.a"),
]  # fmt: skip


@pytest.mark.parametrize(("declarations", "edge", "message", "place"), MISTAKES + OUTSIDE)
def test_it_is_refused_at_its_place(declarations, edge, message, place):
    with pytest.raises(ModelError) as error:
        load(f"{declarations}\nprocess P() {{ state A, B; init A; trans A -> B {{ {edge}; }}; }} system P;")
    assert message in str(error.value)
    assert pointed(error.value).startswith(place)


@pytest.mark.parametrize(
    ("model", "message", "place"),
    [
        ("process P() { int[0, 3] b = 9; state A; init A; } system P;", "b = 9 is out of its range", "9;"),
        ("process P() { state A; init A; } process Q() { state A; init A; } system P < Q;",
         "'<' between processes, a priority", "<"),
        ("process P() { state A; init A; } process Q() { state A; init A; trans A -> A { guard b > 1; }; } system P;",
         "'b' is not declared", "b > 1"),
        ("process P() { state A { x == 3 }; init A; } system P;",
         "'x == 3', an invariant that is an equation with a clock", "x == 3"),
        ("process P() { state A { x' == 0 }; init A; } system P;", "'x'', the rate of a clock (stopwatch)", "x'"),
        ("process P() { state A { x <= 3 || a == 1 }; init A; } system P;", "a disjunction over clocks", "x <= 3"),
        ("process P() { state A { x - y <= 3 }; init A; } system P;", "a diagonal constraint", "x - y"),
    ],
)  # fmt: skip
def test_mistakes_of_templates(model, message, place):
    with pytest.raises(ModelError, match=re.escape(message)) as error:
        load(f"clock x, y; int a; {model}")
    assert pointed(error.value).startswith(place)


def test_two_locations_of_one_name():
    xml = b"""<nta><template><name>P</name><location id="0"><name>A</name></location>
        <location id="1"><name>A</name></location><init ref="0"/></template><system>system P;</system></nta>"""
    with pytest.raises(ModelError, match="Two locations of 'P' are called 'A'"):
        make_network(read_document(xml, "model.xml"))


@pytest.mark.parametrize(
    ("system", "message"),
    [
        ("system Q;", "'Q' is no template and no process."),
        ("Peter = P(); system Petra;", "'Petra' is no template and no process. Did you mean 'Peter'?"),
        ("system P", "The text ends too early. Expected ',' or ';'."),
        ("system P, P;", "'P' stands twice on the system line"),
        ("A = P(1); system A;", "'P' takes 0 arguments, not 1"),
        ("A = P(); A = P(); system A;", "'A' is declared twice"),
        ("P = P(); system P;", "'P' is declared twice"),
        ("system R;", "The parameter 'n' of 'R' has no value. Only a bounded integer may stay free"),
        ("A = S(4); system A;", "n = 4 is out of its range int[0,3]"),
        ("int v; A = S(v); system A;", "The argument for 'n' must be constant; 'v' depends on v"),
        ("int v; A = T(v); system A;", "'v' is int. 'c' is broadcast chan."),
        ("urgent chan v; A = T(v); system A;", "'v' is urgent chan. 'c' is broadcast chan."),
    ],
)
def test_mistakes_of_the_system_section(system, message):
    text = f"""process P() {{ state A; init A; }} process R(int n) {{ state A; init A; }}
        process S(const int[0, 3] n) {{ state A; init A; }}
        process T(broadcast chan &c) {{ state A; init A; }} {system}"""
    with pytest.raises(ModelError, match=re.escape(message)):
        load(text)


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
