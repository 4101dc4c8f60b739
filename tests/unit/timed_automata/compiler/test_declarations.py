"""Variables, types, functions: what they hold and what they do."""

import pytest

from end_effector_hal.errors import RangeError
from tests.unit.timed_automata.explore.models import load, pointed
from timed_automata.network import Semantics


def fired(declarations, updates, **constants):
    """The network and the state after one update."""
    text = (
        f"{declarations} process P() {{ state A; init A; trans A -> A {{ assign {updates}; }}; }} system P;"
    )
    network = load(text, **constants)
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    return network, semantics.fire(network.initial, transition.edges)


def results(declarations, updates):
    network, after = fired(declarations, updates)
    return dict(zip(network.offsets, after.state.values, strict=True))


def test_initial_values():
    network = load("""
        const int N = 2;
        typedef int[0, N] small_t;
        typedef int row_t[3];
        int a, b = 3, c[N] = {4, 5}; bool p, q = true; small_t s = N; row_t rows[N] = {{1, 2, 3}, {4, 5, 6}};
        int[5, 9] high; int[-9, -5] low; int ranged[int[2, 4]] = {7, 8, 9}; int by_type[small_t]; int old := 1;
        process P() { int own = 8; state A; init A; } system P;""")
    values = dict(zip(network.offsets, network.initial.values, strict=True))
    assert values == {
        "a": 0,
        "b": 3,
        "c[0]": 4,
        "c[1]": 5,
        "p": 0,
        "q": 1,
        "s": 2,
        **{f"rows[{i}][{j}]": 3 * i + j + 1 for i in range(2) for j in range(3)},
        "high": 5,
        "low": -5,
        "ranged[2]": 7,
        "ranged[3]": 8,
        "ranged[4]": 9,
        "by_type[0]": 0,
        "by_type[1]": 0,
        "by_type[2]": 0,
        "old": 1,
        "P.own": 8,
    }


def test_an_int_is_bounded_as_in_uppaal_and_a_constant_is_not():
    assert results("const int BIG = 100000; int a;", "a = BIG - 67233") == {"a": 32767}
    with pytest.raises(RangeError, match=r"a = 32768 is out of its range \[-32768,32767\]"):
        fired("const int BIG = 100000; int a;", "a = BIG - 67232")


@pytest.mark.parametrize("update", ["a++", "a = a + 1", "a += 1", "++a", "set(4)", "a <<= 1", "a = twice(a)"])
def test_an_assignment_out_of_range_is_an_error_with_its_place(update):
    functions = "void set(int x) { a = x; } int twice(int x) { return 2 * x; }"
    with pytest.raises(RangeError, match="out of its range") as error:
        fired(f"int[0, 3] a = 3; {functions}", update)
    assert pointed(error.value).startswith("a = x" if update == "set(4)" else update)


def test_updates_happen_one_after_the_other():
    assert results("int a = 1, b = 2, t[2];", "a = b, b = a + 1, t[b - 2] = b") == {
        "a": 2, "b": 3, "t[0]": 0, "t[1]": 3,
    }  # fmt: skip


def test_compound_assignments():
    updates = "a += 3, b -= 3, c *= 2, d /= 2, e %= 3, f &= 6, g |= 1, h ^= 3, i <<= 2, j >>= 1, k++, --l"
    names = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l"]
    values = results(f"int {', '.join(f'{name} = 7' for name in names)};", updates)
    assert list(values.values()) == [10, 4, 14, 3, 1, 6, 7, 4, 28, 3, 8, 6]


def test_booleans_hold_0_or_1():
    values = results("int a = 7; bool p, q = true, r; int n;", "p = a, q = a == 3, r = p && a, n = p == true")
    assert values == {"a": 7, "p": 1, "q": 0, "r": 1, "n": 1}
    assert all(type(value) is int for value in values.values())


def test_arrays_are_assigned_whole():
    values = results("int a[2] = {1, 2}, b[2], g[2][2]; const int K[2] = {8, 9};", "b = a, g[1] = b, a = K")
    assert list(values.values()) == [8, 9, 1, 2, 0, 0, 1, 2]


FUNCTIONS = """
const int N = 4;
typedef int[0, N - 1] index_t;
int list[N] = {4, 1, 3, 1};
int calls;
int largest() { int most = list[0]; for (i : index_t) if (list[i] > most) most = list[i]; return most; }
int count(const int what) { int n; int i; for (i = 0; i < N; i++) { if (list[i] == what) { n++; } } return n; }
int first(int what) { int i = 0; while (i < N && list[i] != what) ++i; return i; }
int digits(int x) { int n = 0; do { n++; x /= 10; } while (x > 0); return n; }
int sign(int x) { if (x > 0) return 1; else if (x < 0) return -1; return 0; }
int total(const int a[N]) { return sum (i : index_t) a[i]; }
int scratch(int a[N]) { a[0] = 100; return a[0] + a[1]; }
int matrix() { int[0, 9] m[2][2] = {{1, 2}, {3, 4}}; m[1][0] = m[0][1] + m[1][1]; return m[1][0] * 10 + m[0][0]; }
void swap(int &a, int &b) { int t = a; a = b; b = t; calls++; }
void fill(int &a[N], int x) { for (i : index_t) a[i] = x; }
void twice(int &a[N]) { fill(a, 2); swap(a[0], calls); }
int shadow(int x) { { int x = 5; x++; } return x; }
bool any(int x) { return exists (i : index_t) list[i] == x; }
"""


@pytest.mark.parametrize(
    ("call", "result"),
    [
        ("largest()", 4),
        ("count(1)", 2),
        ("first(3)", 2),
        ("first(9)", 4),
        ("digits(0) + 10 * digits(1234)", 41),
        ("sign(5) - sign(-5) + sign(0)", 2),
        ("total(list)", 9),
        ("scratch(list) + list[0]", 105),
        ("matrix()", 61),
        ("shadow(1)", 1),
        ("any(3) + any(9)", 1),
    ],
)
def test_functions(call, result):
    assert results(f"int r; {FUNCTIONS}", f"r = {call}")["r"] == result


def test_functions_by_reference():
    assert results(FUNCTIONS, "swap(list[0], list[2])") == {
        "list[0]": 3, "list[1]": 1, "list[2]": 4, "list[3]": 1, "calls": 1,
    }  # fmt: skip
    assert results(FUNCTIONS, "twice(list)") == {
        "list[0]": 0, "list[1]": 2, "list[2]": 2, "list[3]": 2, "calls": 3,
    }  # fmt: skip


def test_a_function_may_reset_clocks():
    _, after = fired("clock x, y[2]; void reset() { for (i : int[0, 1]) y[i] = i; }", "x = 3, reset()")
    assert after.resets == ((1, 3), (2, 0), (3, 1))


def test_constants_may_be_computed_by_functions():
    network = load("""int square(int x) { return x * x; } const int N = square(3); int a[N];
        process P() { state A; init A; } system P;""")
    assert network.constants == {"N": 9}
    assert len(network.offsets) == 9


def test_a_loop_without_end_is_told():
    with pytest.raises(RangeError, match="does not end"):
        fired("int a; void f() { while (true) a = 1 - a; }", "f()")


def test_a_function_that_forgets_its_value_is_told():
    with pytest.raises(RangeError, match="'return' is missing"):
        fired("int a; int f(int x) { if (x > 0) return 1; }", "a = f(0)")


def test_comments_and_words_that_begin_like_keywords():
    network = load("""// a comment; int z;
        int order, iffy /* not
        int here; */, true_north = 3; bool not_now, imply_this;
        process P() { state A; init A; } system P;""")
    assert list(network.offsets) == ["order", "iffy", "true_north", "not_now", "imply_this"]
