"""Templates: parameters by value and by reference, partial instantiation, free parameters, select."""

import pytest

from end_effector_hal.errors import ModelError
from timed_automata import load_network
from timed_automata.network import Semantics


def all_values(network):
    return dict(zip(network.offsets, network.initial.values, strict=True))


def test_free_parameters_make_a_process_for_each_value(load):
    network = load("""const int N = 3; typedef int[0, N - 1] id_t;
        process A(const id_t id, bool flag) { int own = id; state S; init S; } process B() { state S; init S; }
        system B, A;""")
    assert [process.name for process in network.processes] == [
        "B", "A(0,0)", "A(0,1)", "A(1,0)", "A(1,1)", "A(2,0)", "A(2,1)"
    ]  # fmt: skip
    assert all_values(network)["A(2,1).own"] == 2
    assert {process.template for process in network.processes} == {"A", "B"}


def test_the_number_of_processes_follows_a_given_constant(load):
    text = """const int N = 3; typedef int[0, N - 1] id_t; int level[id_t];
        process A(const id_t id) { state S; init S; } system A;"""
    assert len(load(text).processes) == 3
    network = load(text, N=5)
    assert [process.name for process in network.processes] == [f"A({n})" for n in range(5)]
    assert len(network.offsets) == 5


def test_partial_instantiation(load):
    network = load("""int a[2] = {7, 8};
        process T(const int n, int &where, const int list[2]) { int own = n + list[1]; state S; init S; trans
            S -> S { assign where = n }; }
        const int L[2] = {10, 20};
        X(const int[0, 1] i) = T(i + 5, a[0], L); Y = T(9, a[1], L); Z = X(1);
        system X, Y, Z;""")
    assert [process.name for process in network.processes] == ["X(0)", "X(1)", "Y", "Z"]
    assert all_values(network) == {
        "a[0]": 7,
        "a[1]": 8,
        "X(0).own": 25,
        "X(1).own": 26,
        "Y.own": 29,
        "Z.own": 26,
    }
    semantics = Semantics(network)
    states = [semantics.fire(network.initial, t.edges).state for t in semantics.transitions(network.initial)]
    assert [state.values[:2] for state in states] == [(5, 8), (6, 8), (7, 9), (6, 8)]


def test_references_to_clocks_and_channels(load, names):
    network = load("""clock x, ys[2]; broadcast chan go[2], all;
        process Send(broadcast chan &c, clock &x) { state S; init S; trans
            S -> S { guard x >= 3; sync c!; assign x = 0 }; }
        process Hear(broadcast chan &cs[2]) { state S; init S; trans S -> S { sync cs[1]? }; }
        A = Send(go[1], ys[1]); B = Send(all, x); C = Hear(go);
        system A, B, C;""")
    semantics = Semantics(network)
    transitions = list(semantics.transitions(network.initial))
    assert names(network, transitions) == ["A.S>S + C.S>S", "B.S>S"]
    assert [transition.bounds for transition in transitions] == [((3, ">=", 3),), ((1, ">=", 3),)]
    assert network.clocks == ("0", "x", "ys[0]", "ys[1]")
    assert semantics.fire(network.initial, transitions[0].edges).resets == ((3, 0),)


def test_a_reference_to_a_constant_cannot_be_assigned(load):
    with pytest.raises(ModelError, match="'N' is a number"):
        load("const int N = 3; process T(int &n) { state S; init S; } A = T(N); system A;")
    with pytest.raises(ModelError, match="'a' is constant and cannot be assigned"):
        load("""int a; process T(const int &where) { state S; init S; trans S -> S { assign where = 1 }; }
            A = T(a); system A;""")


def test_select_makes_an_edge_for_each_value(load):
    network = load("""int[0, 9] a; process P(const int[1, 2] n) { state S; init S; trans
        S -> S { select i : int[0, n], j : int[i, 2]; guard i != 1; assign a = 3 * i + j }; } system P;""")
    semantics = Semantics(network)
    found = {}
    for transition in semantics.transitions(network.initial):
        (edge,) = transition.edges
        state = semantics.fire(network.initial, (edge,)).state
        found.setdefault(network.processes[edge.process].name, []).append(
            (dict(edge.selected), state.values[0])
        )
    assert found == {
        "P(1)": [({"i": 0, "j": 0}, 0), ({"i": 0, "j": 1}, 1), ({"i": 0, "j": 2}, 2)],
        "P(2)": [
            ({"i": 0, "j": 0}, 0), ({"i": 0, "j": 1}, 1), ({"i": 0, "j": 2}, 2), ({"i": 2, "j": 2}, 8)
        ],
    }  # fmt: skip


def test_local_names_hide_global_ones(load):
    network = load("""int a = 1; const int N = 2; process P(const int N) { int a = N; state S; init S; trans
        S -> S { select a : int[5, 5]; guard a == 5 && N == 7 }; } A = P(7); system A;""")
    assert all_values(network) == {"a": 1, "A.a": 7}
    assert len(list(Semantics(network).transitions(network.initial))) == 1


def test_an_older_file_with_an_instantiation_element(tmp_path):
    path = tmp_path / "old.xml"
    path.write_text("""<nta><template><name>T</name><parameter>const int n</parameter>
        <location id="a"/><init ref="a"/></template>
        <instantiation>A := T(1); B := T(2);</instantiation><system>system A, B;</system></nta>""")
    network = load_network(path)
    assert [process.name for process in network.processes] == ["A", "B"]
    assert network.processes[0].locations[0].name == "a"
