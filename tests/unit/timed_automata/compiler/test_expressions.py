"""Expressions mean what they mean in UPPAAL: C's, with <?, >?, imply, forall, exists and sum."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from end_effector_hal.errors import ModelError, RangeError
from tests.support.nightly import examples
from tests.unit.timed_automata.explore.models import load, pointed
from timed_automata import load_network, make_network, read_document
from timed_automata.network import Semantics

WORLD = """
int[-100000, 100000] r;
int[-10, 10] a = 7, b = -3, c = 2; bool p = true, q = false;
int[0, 9] list[4] = {4, 1, 3, 1}; int[0, 9] grid[2][3] = {{1, 2, 3}, {4, 5, 6}};
const int K[3] = {10, 20, 30};
typedef int[0, 3] index_t;
"""


def evaluate(expression):
    """The expression, computed by the generated code over variables."""
    network = load(
        f"{WORLD} process P() {{ state A; init A; trans A -> A {{ assign r = {expression}; }}; }} system P;"
    )
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    return semantics.fire(network.initial, transition.edges).state.values[network.offset("r")]


@pytest.mark.parametrize(
    ("expression", "result"),
    [
        ("a + b * c", 1),
        ("(a + b) * c", 8),
        ("a / b", -2),  # towards zero
        ("b / c", -1),
        ("a % b", 1),  # the sign of the dividend
        ("b % c", -1),
        ("-a", -7),
        ("a - - b", 4),
        ("a <? b", -3),
        ("a >? b", 7),
        ("a - 1 <? c", 2),  # binds less than -
        ("c <? a < b", 0),  # and more than <
        ("a << c", 28),
        ("a >> 1", 3),
        ("a & 3", 3),
        ("c | 5", 7),
        ("c ^ 7", 5),
        ("1 | 2 == 2", 1),  # == binds more than |
        ("a == 7 && b == -3", 1),
        ("a == 7 and not b == -3", 0),
        ("p imply q", 0),
        ("q imply p imply q", 0),  # from the left: (q imply p) imply q
        ("q or p and q", 0),
        ("!p + 1", 1),
        ("p + p", 2),
        ("p == (a > b)", 1),
        ("a > b ? c : 100", 2),
        ("q ? 1 : p ? 2 : 3", 2),
        ("list[2]", 3),
        ("list[list[1]]", 1),
        ("grid[1][2]", 6),
        ("grid[c - 1][list[3]]", 5),
        ("K[c]", 30),
        ("forall (i : index_t) list[i] > 0", 1),
        ("forall (i : index_t) list[i] > 1 || p", 1),  # reaches to the end
        ("(forall (i : index_t) list[i] > 1) || q", 0),
        ("exists (i : int[0, 3]) list[i] == 4 && i == 0", 1),
        ("sum (i : index_t) list[i]", 9),
        ("sum (i : int[0, 1]) sum (j : int[0, 2]) grid[i][j]", 21),
        ("sum (i : int[1, 20]) i", 210),
        ("forall (i : int[1, 20]) exists (j : int[0, 3]) i % 4 == j", 1),
        ("exists (i : int[1, 20]) i * i == 50", 0),
        ("c + (exists (i : bool) i == q)", 3),
        ("list == list", 1),
        ("true + true", 2),
    ],
)
def test_value(expression, result):
    assert evaluate(expression) == result


@pytest.mark.parametrize("expression", ["a / (b + 3)", "a % (b + 3)"])
def test_division_by_zero_is_told_with_its_place(expression):
    with pytest.raises(RangeError, match="Division by zero") as error:
        evaluate(expression)
    assert pointed(error.value).startswith(expression)


def test_an_index_out_of_range_is_told():
    with pytest.raises(RangeError, match=r"Index -3 of 'list' is outside of 0 to 3"):
        evaluate("list[b]")
    with pytest.raises(ModelError, match=r"Index 4 of 'list' is outside of 0 to 3"):
        evaluate("list[4]")


def test_the_right_operand_is_not_evaluated_where_the_left_decides():
    assert evaluate("b >= 0 && list[b] == 1") == 0
    assert evaluate("b < 0 || list[b] == 1") == 1
    assert evaluate("b >= 0 imply list[b] == 1") == 1
    assert evaluate("b < 0 ? 5 : list[b]") == 5


def test_constants_may_make_an_operand_meaningless_that_is_never_evaluated():
    """A description with one actuator must not break `i > 0 && valve[i - 1]`."""
    text = """const int N = 1, Z = 0; int[0, 5] a[N]; int[0, 5] b = 1; chan c[N];
        process P(const int[0, N - 1] id) { clock x; state A; init A; trans
            A -> A { guard id > 0 && a[id - 1] == 0 && x >= a[id - 1]; sync c[id - 1]!; assign a[id - 1] = 5 },
            A -> A { guard Z != 0 && 3 / Z == 1; assign b = 3 / Z },
            A -> A { guard forall (i : int[0, 3]) i >= N || a[i] == 0; assign b = N > 1 ? a[N] : 2 }; }
        system P;"""
    network = load(text)
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    assert semantics.fire(network.initial, transition.edges).state.values == (0, 2)


# Random expressions, against an evaluator that shares no code with the product. -----------------------------

VARIABLES = {"a": 7, "b": -3, "c": 2, "p": 1, "q": 0}
BINARY = ["+", "-", "*", "/", "%", "<?", ">?", "==", "!=", "<", "<=", ">", ">=", "&&", "||", "imply"]


def c_divide(x, y):
    return int(x / y)


OPERATIONS = {
    "+": lambda x, y: x() + y(),
    "-": lambda x, y: x() - y(),
    "*": lambda x, y: x() * y(),
    "/": lambda x, y: c_divide(x(), y()),
    "%": lambda x, y: (lambda n, d: n - d * c_divide(n, d))(x(), y()),
    "<?": lambda x, y: min(x(), y()),
    ">?": lambda x, y: max(x(), y()),
    "==": lambda x, y: int(x() == y()),
    "!=": lambda x, y: int(x() != y()),
    "<": lambda x, y: int(x() < y()),
    "<=": lambda x, y: int(x() <= y()),
    ">": lambda x, y: int(x() > y()),
    ">=": lambda x, y: int(x() >= y()),
    "&&": lambda x, y: int(bool(x()) and bool(y())),
    "||": lambda x, y: int(bool(x()) or bool(y())),
    "imply": lambda x, y: int(not x() or bool(y())),
}

leaves = st.sampled_from([*VARIABLES, "0", "1", "3", "true"])
trees = st.recursive(
    leaves,
    lambda children: st.one_of(
        st.tuples(st.sampled_from(BINARY), children, children),
        st.tuples(st.sampled_from(["!", "-"]), children),
        st.tuples(st.just("?"), children, children, children),
    ),
    max_leaves=8,
)


def text(tree):
    if isinstance(tree, str):
        return tree
    op, *parts = tree
    inner = [f"({text(part)})" for part in parts]
    if op == "?":
        return f"{inner[0]} ? {inner[1]} : {inner[2]}"
    return f"{op}{inner[0]}" if len(inner) == 1 else f"{inner[0]} {op} {inner[1]}"


def meaning(tree):
    if isinstance(tree, str):
        return VARIABLES.get(tree, 1 if tree == "true" else 0 if not tree.isdigit() else int(tree))
    op, *parts = tree
    if op == "?":
        return meaning(parts[1]) if meaning(parts[0]) else meaning(parts[2])
    if len(parts) == 1:
        return int(not meaning(parts[0])) if op == "!" else -meaning(parts[0])
    return OPERATIONS[op](lambda: meaning(parts[0]), lambda: meaning(parts[1]))


def network_of(tree, low, high, keyword=""):
    xml = f"""<nta><declaration>int[{low},{high}] r; {keyword}int[-4, 9] a = 7, b = -3, c = 2;
        {keyword}bool p = true, q = false;</declaration>
        <template><name>P</name><location id="A"/><init ref="A"/>
        <transition><source ref="A"/><target ref="A"/>
        <label kind="assignment"><![CDATA[r = {text(tree)}]]></label></transition></template>
        <system>system P;</system></nta>"""
    return make_network(read_document(xml.encode(), "random"))


def result_of(network):
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    return semantics.fire(network.initial, transition.edges).state.values[0]


@settings(max_examples=examples(50, 3000), deadline=None)
@given(tree=trees)
def test_random_expressions_with_variables_and_with_constants(tree):
    """Computed at run time and folded at load time, both as the independent evaluator has it."""
    try:
        expected = meaning(tree)
    except ZeroDivisionError:
        return
    for keyword in ("", "const "):
        try:
            network = network_of(tree, -1_000_000, 1_000_000, keyword)
        except ModelError as error:  # a division by a written zero is refused even if it is never reached
            if not re.search("Division by zero in '.*[/%] .?0", str(error)):
                raise
            continue
        assert result_of(network) == expected, (text(tree), keyword)


@pytest.mark.parametrize(
    "op", ["+", "-", "*", "/", "%", "<?", ">?", "p?", "q?", "neg", "&", "|", "^", "<<", ">>"]
)
def test_what_leaves_its_range_is_told_whatever_was_computed(op):
    """No check of a range is left out that is needed, by any operator."""
    operations = {
        **OPERATIONS,
        "&": lambda x, y: x() & y(),
        "|": lambda x, y: x() | y(),
        "^": lambda x, y: x() ^ y(),
        "<<": lambda x, y: x() << y(),
        ">>": lambda x, y: x() >> y(),
        "p?": lambda x, y: x(),
        "q?": lambda x, y: y(),
        "neg": lambda x, y: -x(),
    }
    for left in ("a", "b", "c", "3"):
        for right in ("c", "5") if op in ("<<", ">>") else ("a", "b", "c", "5"):
            trees = {"p?": ("?", "p", left, right), "q?": ("?", "q", left, right), "neg": ("-", left)}
            tree, x, y = trees.get(op, (op, left, right)), meaning(left), meaning(right)
            expected = operations[op](lambda x=x: x, lambda y=y: y)
            assert result_of(network_of(tree, expected, expected)) == expected
            for low, high in ((-2, -1), (1, 2), (-100, -1), (1, 100)):
                with pytest.raises(RangeError, match="out of its range"):
                    result_of(network_of(tree, expected + low, expected + high))


def test_the_shipped_format_is_read_from_a_path(tmp_path):
    with pytest.raises(ModelError, match="cannot be read"):
        load_network(tmp_path / "absent.xml")
