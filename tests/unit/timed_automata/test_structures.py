"""Structures, meta variables and scalar sets: what they mean in UPPAAL, they mean here."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from random import Random
from typing import Any
from xml.sax.saxutils import escape

import pytest
from hypothesis import given, note, settings
from hypothesis import strategies as st

from tests.support.nightly import PHASES, examples
from tests.unit.timed_automata.explore.models import load
from tests.unit.timed_automata.simulate.run_facts import assert_is_run
from timed_automata import Event, Execution, Network, load_network, make_network, read_document
from timed_automata.errors import ModelError, RangeError, UsageError
from timed_automata.explain import Names, explain
from timed_automata.explore import Explorer, verify
from timed_automata.monitor import Monitor
from timed_automata.network import export
from timed_automata.queries import parse_query
from timed_automata.simulate import simulate

TYPES = """
typedef struct { int[0,9] a; bool b; } pair_t;
typedef struct { pair_t p[2]; int[0,9] n; } deep_t;
"""


def network(declarations: str, update: str = "", *, own: str = "", guard: str = "") -> Network:
    return make_network(
        read_document(
            f"""<nta><declaration>{escape(TYPES + declarations)}</declaration>
            <template><name>P</name><declaration>{escape(own)}</declaration>
            <location id="s"><name>S</name></location><location id="e"><name>E</name></location><init ref="s"/>
            <transition><source ref="s"/><target ref="e"/><label kind="guard">{escape(guard)}</label>
            <label kind="assignment">{escape(update)}</label></transition></template>
            <system>system P;</system></nta>""".encode(),
            "m.xml",
        )
    )


def after(declarations: str, update: str) -> dict[str, int]:
    """What is not zero after one update."""
    made = network(declarations, update)
    values: list[int] = list(made.initial.values)
    (edge,) = made.processes[0].edges
    assert edge.update is not None
    edge.update(values, [])
    return {name: values[at] for name, at in made.offsets.items() if values[at]}


@pytest.mark.parametrize(
    ("declarations", "update", "left"),
    [
        ("struct { int x, y[2]; } s;", "s.y[1] = 3, s.x = s.y[1] + 1", {"s.x": 4, "s.y[1]": 3}),
        ("pair_t s = {3, true}, t;", "t = s, s.a = 0", {"s.b": 1, "t.a": 3, "t.b": 1}),
        ("pair_t l[3]; int i = 1;", "l[i].a = 4, l[2] = l[i], l[i].b = true",
         {"i": 1, "l[1].a": 4, "l[1].b": 1, "l[2].a": 4}),
        ("deep_t d = {{{1, false}, {2, true}}, 3}, e;", "e = d", {
            "d.p[0].a": 1, "d.p[1].a": 2, "d.p[1].b": 1, "d.n": 3,
            "e.p[0].a": 1, "e.p[1].a": 2, "e.p[1].b": 1, "e.n": 3}),
        ("const pair_t K = {b: true, a: 4}; deep_t d = {{K, {5, K.b}}, K.a};", "d.n++",
         {"d.p[0].a": 4, "d.p[0].b": 1, "d.p[1].a": 5, "d.p[1].b": 1, "d.n": 5}),
        ("pair_t s; pair_t f(int[0,9] k) { pair_t r = {k, k > 2}; return r; }", "s = f(7), s.a = f(s.a).a - 1",
         {"s.a": 6, "s.b": 1}),
        ("pair_t s, t; void f(pair_t v, pair_t &r) { v.a = 9; r = v; r.b = true; }", "s.a = 2, f(s, t)",
         {"s.a": 2, "t.a": 9, "t.b": 1}),
        ("deep_t d; void f(int[0,9] &k) { k = 8; }", "f(d.p[1].a), f(d.n)", {"d.p[1].a": 8, "d.n": 8}),
        ("pair_t s, t; bool same() { pair_t k = s; return k == t && !(k != t); } int n;",
         "n = same(), s.a = 1, n += 2 * same()", {"n": 1, "s.a": 1}),
        ("pair_t s;", "s.a = s.b = 1", {"s.a": 1, "s.b": 1}),
        ("meta int m; meta pair_t s; int k;", "m = 4, s.a = m, k = s.a", {"m": 4, "s.a": 4, "k": 4}),
        ("typedef scalar[3] id_t; id_t i; int[0,9] l[id_t];", "i = 2, l[i] = 5", {"i": 2, "l[2]": 5}),
        ("int8_t i; uint8_t j = UINT8_MAX; const int32_t BIG = INT32_MAX; int32_t k;", "i = INT8_MIN, k = BIG",
         {"i": -128, "j": 255, "k": 2147483647}),
        ("int n;", "n = 1 + \\\n 2", {"n": 3}),
    ],
)  # fmt: skip
def test_what_an_update_leaves(declarations: str, update: str, left: dict[str, int]) -> None:
    assert after(declarations, update) == left


@pytest.mark.parametrize(
    ("declarations", "update", "message"),
    [
        ("pair_t s;", "s.c = 1", "'s' has no field 'c'"),
        ("pair_t s;", "s.bb = 1", "Did you mean 'b'?"),
        ("pair_t s;", "s = 1", "'s' is pair_t. Expected '=' and a structure like it."),
        ("pair_t s; deep_t d;", "s = d", "'s' is pair_t"),
        ("pair_t s; struct { int[0,8] a; bool b; } t;", "s = t", "'s' is pair_t"),
        ("pair_t s; int n;", "n = s", "'s' is a structure. Expected a number."),
        ("pair_t s; int n;", "n = n.a", "'n' is no structure."),
        ("pair_t s = {1};", "s.a = 1", "'s' needs 2 values, not 1."),
        ("pair_t s = {a: 1, c: 2};", "s.a = 1", "'s' has the fields a, b."),
        ("pair_t s = {10, true};", "s.a = 1", "s = 10 is out of its range [0,9]."),
        ("pair_t s = 4;", "s.a = 1", "'s' is a structure of 2. Expected {…}."),
        ("struct { int a; int a; } s;", "s.a = 1", "The structure has two fields 'a'."),
        ("const pair_t K = {1, true};", "K.a = 1", "'K' is constant"),
        ("pair_t s, t; int n;", "n = s < t", "cannot be compared by '<'"),
        ("pair_t s; pair_t f() { int k; return k; }", "s = f()", "'k' is no pair_t."),
        ("pair_t l[2]; int i;", "l[i++].a = 3", "'l[i++]', an assignment in the index of a whole array"),
        ("typedef scalar[0] id_t;", "", "The size of a scalar set is 0."),
        ("meta clock x;", "", "'meta' belongs to int and bool, not to clock."),
    ],
)  # fmt: skip
def test_a_mistake_is_named(declarations: str, update: str, message: str) -> None:
    with pytest.raises(ModelError) as error:
        network(declarations, update)
    assert message in str(error.value)
    assert str(error.value).startswith("m.xml:")


# Against a second implementation: structures as dictionaries, copied as a whole

Env = dict[str, Any]
Place = tuple[str, Callable[[Env], tuple[Any, Any]]]  # its text, and container and key in an environment


def _place(text: str, *keys: Any) -> Place:
    def find(env: Env) -> tuple[Any, Any]:
        at: Any = env
        for key in keys[:-1]:
            at = at[env["i"] if key == "i" and isinstance(at, list) else key]
        return at, env["i"] if keys[-1] == "i" and isinstance(at, list) else keys[-1]

    return text, find


PAIRS = [
    _place("s", "s"),
    _place("t", "t"),
    *(_place(f"{d}.p[{k}]", d, "p", k) for d in "de" for k in (0, 1, "i")),
]
DEEP = [_place(d, d) for d in "de"]
NUMBERS = [_place("i", "i"), *(_place(f"{d}.n", d, "n") for d in "de")]
NUMBERS += [(f"{text}.a", lambda env, find=find: (_get(find, env), "a")) for text, find in PAIRS]
TRUTHS = [(f"{text}.b", lambda env, find=find: (_get(find, env), "b")) for text, find in PAIRS]


def _get(find: Callable[[Env], tuple[Any, Any]], env: Env) -> Any:
    container, key = find(env)
    return container[key]


FUNCTIONS = """
pair_t made(int[0,9] k) { pair_t r; r.a = 9 - k; r.b = k > 4; return r; }
void put(pair_t &r, pair_t v) { v.b = !v.b; r = v; v.a = 0; }
deep_t both(pair_t v) { deep_t r = {{v, {1, true}}, v.a}; return r; }
int[0,1] i; pair_t s, t; deep_t d, e;
"""


@st.composite
def steps(draw: st.DrawFn) -> tuple[str, Callable[[Env], None]]:
    kind = draw(
        st.sampled_from(("whole", "whole", "deep", "number", "number", "truth", "made", "put", "both", "i"))
    )
    places = {"deep": DEEP, "both": DEEP, "number": NUMBERS[1:], "truth": TRUTHS, "i": NUMBERS[:1]}.get(
        kind, PAIRS
    )
    (to, target), (of, source) = draw(st.sampled_from(places)), draw(st.sampled_from(places))
    number, (pair, paired) = draw(st.integers(0, 9)), draw(st.sampled_from(PAIRS))

    def value(env: Env) -> Any:
        if kind == "made":
            return {"a": 9 - number, "b": int(number > 4)}
        if kind == "both":
            from_pair = deepcopy(_get(paired, env))
            return {"p": [from_pair, {"a": 1, "b": 1}], "n": from_pair["a"]}
        if kind == "i" or (kind == "number" and number < 5):
            return number % 2 if kind == "i" else number
        found = deepcopy(_get(source, env))
        return {**found, "b": 1 - found["b"]} if kind == "put" else found

    def take(env: Env) -> None:
        container, key = target(env)
        container[key] = value(env)

    text = {"made": f"{to} = made({number})", "both": f"{to} = both({pair})", "put": f"put({to}, {of})"}
    text |= {"i": f"i = {number % 2}"} | ({"number": f"{to} = {number}"} if number < 5 else {})
    return text.get(kind, f"{to} = {of}"), take


@settings(max_examples=examples(60, 3000), deadline=None, phases=PHASES)
@given(st.lists(steps(), max_size=12), st.sampled_from(PAIRS), st.sampled_from(PAIRS))
def test_structures_are_copied_and_compared_as_a_whole(
    taken: list[tuple[str, Callable[[Env], None]]], one: Place, other: Place
) -> None:
    env: Env = {"i": 0, "s": {"a": 0, "b": 0}, "t": {"a": 0, "b": 0}}
    env |= {name: {"p": [{"a": 0, "b": 0}, {"a": 0, "b": 0}], "n": 0} for name in "de"}
    for _, take in taken:
        take(env)
    note(update := ", ".join(text for text, _ in taken) or "i = 0")
    explorer = Explorer(network(FUNCTIONS, update))
    facts = [f"{text} == {_get(find, env)}" for text, find in (*NUMBERS, *TRUTHS)]
    assert explorer.check(f"A[] P.E imply ({' && '.join(facts)})").holds
    assert explorer.check("E<> P.E").holds
    same = _get(one[1], env) == _get(other[1], env)
    assert explorer.check(f"E<> P.E && {one[0]} == {other[0]}").holds is same
    assert explorer.check(f"E<> P.E && {one[0]} != {other[0]}").holds is not same
    assert explorer.check("E<> P.E && d == e").holds is (env["d"] == env["e"])


# The same structures in a network that runs in time

LAMP = """typedef struct { int[1,9] least; int[1,9] most; } limits_t;
typedef struct { limits_t limits; int[0,3] level; } lamp_t;
const limits_t TIMES = {2, 4};
clock x; broadcast chan press, lit; lamp_t lamp = {TIMES, 0}; int[0,3] wanted;
process Lamp(lamp_t &mine, const limits_t times) {
  state Off, On { x <= mine.limits.most }; init Off;
  trans Off -> On { sync press?; assign x = 0, mine.level = wanted; },
    On -> Off { guard x >= times.least; sync lit!; assign mine.level = 0; };
}
process User() { state U; init U; trans U -> U { select k : int[0,3]; sync press!; assign wanted = k; }; }
L = Lamp(lamp, TIMES); system L, User;"""


@pytest.mark.parametrize(
    ("query", "holds"),
    [
        ("A[] L.On imply x <= lamp.limits.most", True),
        ("E<> L.On && x == 4 && lamp.level == 3", True),
        ("A[] L.Off imply lamp.level == 0", True),
        ("A[] L.On imply L.mine == lamp && L.times == TIMES", True),
        ("A[] lamp.limits == TIMES", True),
        ("E<> L.Off && x > 0 && x < 2 && wanted > 0", False),
        ("L.On --> L.Off", False),  # the user may press without end at one instant
        ("A<> L.On", False),
    ],
)
def test_a_structure_in_time(query: str, holds: bool) -> None:
    assert Explorer(load(LAMP)).check(query).holds is holds


def test_it_is_simulated_and_followed() -> None:
    made = load(LAMP)
    for seed in range(10):
        assert_is_run(simulate(made, Random(seed), steps=20).trace)


def test_it_is_executed_and_monitored() -> None:
    made = load(LAMP)
    record: list[Any] = []
    lamp = Execution(made, ["L"], ["wanted"], observe=record.append)
    lamp.start(at=0)
    lamp.receive(Event("press", {"wanted": 2}), at=1_000)
    assert (lamp.location("L"), lamp.value("lamp.level"), lamp.deadline) == ("On", 2, 3_000)
    lamp.advance(3_000)
    assert (lamp.location("L"), lamp.value("lamp.level")) == ("Off", 0)
    monitor = Monitor(made, ["L"], ["wanted"])
    for observation in record:
        monitor.observe(observation)
    assert (monitor.steps, monitor.objections) == (2, [])


def test_each_field_has_its_own_range() -> None:
    made = load(
        """struct { int[0,3] a; int[0,900] b; } s; broadcast chan go;
        process P() { state A, B; init A; trans A -> B { guard s.a > 1 && s.b > 1; sync go?; }; }
        process E() { state C; init C; trans C -> C { sync go!; assign s.a = 2, s.b = 2; }; } system P, E;"""
    )
    running = Execution(made, ["P"], ["s"])
    running.start(at=0)
    with pytest.raises(UsageError, match=r"s\.a = 900 is no integer from 0 to 3"):
        running.receive(Event("go", {"s.a": 900}), at=1)
    with pytest.raises(RangeError, match=r"s\.a = 4 is out of its range \[0,3\]"):
        verify(network("struct { int[0,3] a; int[0,900] b; } s; int n = 4;", "s.a = n"), "E<> P.E")


def test_a_constant_of_structures_is_given_as_lists_and_written_back(tmp_path: Any) -> None:
    made = network("const pair_t K[2] = {{1, false}, {2, true}}; int n;", "n = K[1].a", guard="K[0].b")
    assert made.constants == {"K": [[1, 0], [2, 1]]}
    assert not verify(made, "E<> P.E").holds
    given_ = make_network(made.document, {"K": [[1, True], [7, True]]})
    assert verify(given_, "E<> P.E && n == 7").holds
    (tmp_path / "m.xml").write_bytes(export(given_))
    assert load_network(tmp_path / "m.xml").constants == {"K": [[1, 1], [7, 1]]}
    with pytest.raises(UsageError, match="'K' needs a list of 2 values"):
        make_network(made.document, {"K": [1, 2]})


def test_a_run_is_explained_by_the_fields() -> None:
    made = network("pair_t s; pair_t l[2];", "s.a = 3, l[1].a = 2")
    query = parse_query("A[] s.a < 3 || l[1].a != 2")
    trace = verify(made, query).trace
    assert trace is not None
    assert "s.a 0 → 3" in str(trace)
    said = explain(trace, query, Names(made)).sentence
    assert "s.a" in said
    assert "l[1].a" in said


@pytest.mark.parametrize(
    ("query", "holds"),
    [
        ("A[] P.own.a == 4", True),
        ("E<> make(5).a == 5 && P.half(own2).a == 2", True),
        ("A[] forall (k : int[0,1]) l[k].a == k", True),
        ("A[] P.flag.b", True),
    ],
)
def test_a_query_names_fields_and_functions_of_structures(query: str, holds: bool) -> None:
    made = network(
        "pair_t own2 = {4, true}, l[2] = {{0, true}, {1, true}};"
        "pair_t make(int[0,9] k) { pair_t r = {k, true}; return r; }",
        own="pair_t own = {4, false}, flag = {0, true}; pair_t half(pair_t v) { v.a = v.a / 2; return v; }",
    )
    assert Explorer(made).check(query).holds is holds


SCALARS = """typedef scalar[{n}] id_t; clock x[id_t]; int[0,{n}] set; meta int[0,{n}] last;
bool free = true; id_t owner;
process P(const id_t me) {{ state Idle, Request {{ x[me] <= 2 }}, Wait, Critical; init Idle;
  trans Idle -> Request {{ guard free; assign x[me] = 0; }},
    Request -> Wait {{ assign x[me] = 0, owner = me, free = false, last = last; }},
    Wait -> Request {{ guard free; assign x[me] = 0; }},
    Wait -> Critical {{ guard x[me] > {k} && !free && owner == me; }},
    Critical -> Idle {{ assign free = true; }}; }}
system P;"""


@pytest.mark.parametrize(("k", "excluded"), [(2, True), (1, False)])
def test_fischer_with_a_scalar_set(k: int, excluded: bool) -> None:
    """The waiting time must be longer than the time to write; with less, two are in the critical section."""
    explorer = Explorer(load(SCALARS.format(n=3, k=k)))
    query = "A[] forall (i : id_t) forall (j : id_t) P(i).Critical && P(j).Critical imply i == j"
    assert explorer.check(query).holds is excluded
    assert explorer.check("E<> exists (i : id_t) P(i).Critical").holds
