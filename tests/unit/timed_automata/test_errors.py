"""Every mistake is told at its place, with what is wrong and what is likely meant."""

import pytest

from end_effector_hal.errors import ModelError
from timed_automata import make_network, read_document

# (declarations, template's declarations, edge, what the message says, what the place points at)
MISTAKES = [
    ("int a = ;", "", "", "';' is not expected here. Expected", ";"),
    ("int a", "", "", "The text ends too early. Expected", ""),
    ("int a b;", "", "", "'b' is not expected here", "b;"),
    ("int if = 1;", "", "", "'if' is not expected here. Expected '[' or a name", "if"),
    ("int a = 3 $ 4;", "", "", "'$' is no part of the language", "$"),
    ("int a; /* no end", "", "", "This comment does not end. Expected '*/'", "/* no"),
    ("int f() { return 1 }", "", "", "'}' is not expected here. Expected", "}"),
    ("int a; int a;", "", "", "'a' is declared twice", "a;"),
    ("int a = b;", "", "", "'b' is not declared", "b;"),
    (
        "int evidence; int a = evidenc;",
        "",
        "",
        "'evidenc' is not declared. Did you mean 'evidence'?",
        "evidenc;",
    ),
    ("typedef int[0, 3] id_t; id_d a;", "", "", "'id_d' is no type. Did you mean 'id_t'?", "id_d"),
    ("int b; int a = b;", "", "", "must be constant; 'b' depends on b", "b;"),
    ("int b; int a[b];", "", "", "The size of an array must be constant", "b]"),
    ("int a[0];", "", "", "The size of an array is 0", "0]"),
    ("int[3, 2] a;", "", "", "'int[3, 2]' is empty", "int[3"),
    ("int[0, 3] a = 4;", "", "", "a = 4 is out of its range [0,3]", "4;"),
    ("int a[2] = {1, 2, 3};", "", "", "'a' needs 2 values, not 3", "{1"),
    ("int a[2] = 1;", "", "", "'a' is an array of 2", "1;"),
    ("int a = {1};", "", "", "Braces where 'a' has a single value", "{1"),
    ("const int N;", "", "", "The constant 'N' has no value", "N;"),
    ("chan c = 1;", "", "", "A chan has no initialiser", "c ="),
    ("broadcast int a;", "", "", "'broadcast' belongs to channels, not to int", "broadcast"),
    ("const clock x;", "", "", "'const' belongs to int and bool, not to clock", "const"),
    ("void a;", "", "", "'a' cannot be void", "a;"),
    ("int f(int x) { return x; } const int N = f();", "", "", "'f' takes 1 arguments, not 0", "f();"),
    ("void f() { return 1; }", "", "", "A void function returns no value", "return"),
    ("int f() { return; }", "", "", "A value of type int is expected after 'return'", "return"),
    ("int f() { return f(); }", "", "", "'f' is not declared", "f();"),
    ("const int N = 1; void f() { N = 2; }", "", "", "'N' is constant and cannot be assigned", "N = 2"),
    ("void f(const int x) { x++; }", "", "", "'x' is constant and cannot be assigned", "x++"),
    ("void f() { int a[2] = {1}; }", "", "", "'a' needs 2 values, not 1", "{1"),
    ("void f(int &x) { x = 1; } const int N = 2; void g() { f(N); }", "", "", "'N' is a number", "N);"),
    ("void f(int &x) { x = 1; } int[0, 3] a; void g() { f(a); }", "", "", "'a' is int[0,3]", "a);"),
    ("", "int[0, 3] b = 9;", "", "b = 9 is out of its range", "9;"),
    ("int a;", "", "guard a = 1", "an assignment inside an expression", "a = 1"),
    ("int a;", "", "guard a +", "The text ends too early. Expected an expression", "</label>"),
    ("int a;", "", "guard a 1", "'1' is not expected here. Expected '=', an operator or the end", "1"),
    ("int a[2];", "", "guard a == 1", "'a' is an array", "a == 1"),
    ("int a[2];", "", "guard a[2] == 1", "Index 2 of 'a' is outside of 0 to 1", "2]"),
    ("int a;", "", "guard a[0] == 1", "'a' is no array", "a[0]"),
    ("chan c;", "", "guard c == 1", "'c' is a channel", "c =="),
    ("typedef int t;", "", "guard t == 1", "'t' is a type", "t =="),
    ("int f() { return 1; }", "", "guard f == 1", "'f' is a function", "f =="),
    ("int a;", "", "guard a(1) == 1", "'a' is not a function", "a(1)"),
    ("void f() { }", "", "guard f() == 1", "'f' returns nothing", "f()"),
    ("int a; int f() { a = 1; return a; }", "", "guard f() == 1", "The guard 'f() == 1' changes a", "f()"),
    ("clock x[2];", "", "guard x > 1", "'x' is an array of clocks", "x >"),
    ("int a;", "", "sync a!", "'a' is no channel", "a!"),
    ("chan c[2];", "", "sync c!", "'c' is an array of channels", "c!"),
    ("chan c;", "", "sync c", "The text ends too early. Expected", "</label>"),
    ("chan c;", "", "sync d!", "'d' is not declared", "d!"),
    ("int a;", "", "assign a == 1", "'a == 1' has no effect. Did you mean '='?", "a == 1"),
    ("int a;", "", "assign 3 = a", "'3' cannot be assigned. Expected a variable", "3 ="),
    ("const int N = 1;", "", "assign N = 2", "'N' is constant and cannot be assigned", "N = 2"),
    ("const int N[2] = {1, 2};", "", "assign N[0] = 2", "'N' is constant and cannot be assigned", "N[0]"),
    ("int[0, 3] a;", "", "assign a = 4", "a = 4 is out of its range [0,3]", "a = 4"),
    ("chan c;", "", "assign c = 1", "'c' is a channel and cannot be assigned", "c = 1"),
    ("int a[2], b[3];", "", "assign a = b", "'a' is int[2]", "a = b"),
    ("int a;", "", "select i : int[0, 1]; assign i = 1", "'i' is constant and cannot be assigned", "i = 1"),
    ("int a;", "", "select i : int; assign a = i", "'int' is no bounded type", "int"),
    ("int a;", "", "select i : int[0, 1], i : int[0, 1]", "'i' is declared twice", "i :"),
    ("int a;", "", "select i : int[0, 20000]", "More than 10000 values are selected", "i :"),
    ("int a; clock x;", "", "assign a = x", "the clock 'x' as a number", "x"),
    (
        "int a;",
        "",
        "guard forall (i : 3) a == i",
        "'3' is not expected here. Expected a name or a type",
        "3)",
    ),
]


@pytest.mark.parametrize(("declarations", "own", "edge", "message", "place"), MISTAKES)
def test_a_mistake_is_told_at_its_place(load, pointed, declarations, own, edge, message, place):
    text = (
        f"{declarations}\nprocess P() {{ {own} state A, B; init A; trans A -> B {{ {edge}; }}; }} system P;"
    )
    with pytest.raises(ModelError) as error:
        load(text)
    assert message in str(error.value)
    assert pointed(error.value).startswith(place)


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
def test_mistakes_of_the_system_section(load, system, message):
    text = f"""process P() {{ state A; init A; }} process R(int n) {{ state A; init A; }}
        process S(const int[0, 3] n) {{ state A; init A; }}
        process T(broadcast chan &c) {{ state A; init A; }} {system}"""
    with pytest.raises(ModelError) as error:
        load(text)
    assert message in str(error.value)


def test_a_template_that_is_not_used_is_checked_too(load):
    with pytest.raises(ModelError, match="'b' is not declared"):
        load("""process P() { state A; init A; } process Unused() { state A; init A; trans A -> A { guard b > 1; }; }
            system P;""")


def test_two_locations_of_one_name():
    xml = b"""<nta><template><name>P</name><location id="0"><name>A</name></location>
        <location id="1"><name>A</name></location><init ref="0"/></template><system>system P;</system></nta>"""
    with pytest.raises(ModelError, match="Two locations of 'P' are called 'A'"):
        make_network(read_document(xml, "model.xml"))


DEEP = ["!" * 3000 + "1", "-(" * 300 + "a" + ")" * 300, "+".join("a" * 3000), "a ? 1 : " * 300 + "0"]


@pytest.mark.parametrize("deep", DEEP)
def test_deep_nesting_is_told_without_a_traceback(load, deep):
    with pytest.raises(ModelError, match="nested too deeply"):
        load(f"int a; process P() {{ state A; init A; trans A -> A {{ guard {deep} == 1; }}; }} system P;")


def test_parentheses_alone_are_no_nesting(load):
    deep = "(" * 400 + "1" + ")" * 400
    load(f"int a; process P() {{ state A; init A; trans A -> A {{ guard {deep} == 1; }}; }} system P;")
