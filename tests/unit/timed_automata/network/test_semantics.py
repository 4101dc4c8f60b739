"""UPPAAL's semantics to the letter, its traps included."""

import pytest

from end_effector_hal.errors import ModelError, RangeError
from tests.unit.timed_automata.explore.models import load, names
from tests.unit.timed_automata.explore.models import network as network_of
from timed_automata import load_network
from timed_automata.network import Semantics

IDLE = "state A, B; init A; trans"


def after(network, transition):
    return Semantics(network).fire(network.initial, transition.edges)


def test_a_state_is_a_value():
    from timed_automata import State

    assert {State((0, 1), (2,)): 1}[State((0, 1), (2,))] == 1


def test_order_of_transitions_is_that_of_the_system_line_then_of_the_file():
    network = load(f"""chan c;
        process P() {{ {IDLE} A -> B {{ sync c!; }}, A -> A {{ }}, A -> B {{ }}; }}
        process Q() {{ {IDLE} A -> A {{ }}, A -> B {{ sync c?; }}, A -> A {{ sync c?; }}; }}
        system Q, P;""")
    semantics = Semantics(network)
    assert names(network, semantics.transitions(network.initial)) == [
        "Q.A>A", "P.A>B + Q.A>B", "P.A>B + Q.A>A", "P.A>A", "P.A>B",
    ]  # fmt: skip


TRANSITIONS = [
    ("binary synchronisation needs two processes",
     ("chan c;", "P(const int[0, 1] i): A -> B; sync: c! | A -> A; sync: c?"),
     ["P(0).A>B + P(1).A>A", "P(1).A>B + P(0).A>A"]),
    ("a process does not synchronise with itself", ("chan c;", "P: A -> B; sync: c! | A -> A; sync: c?"), []),
    ("a broadcast without receivers is sent all the same",
     ("broadcast chan c;", "S: A -> B; sync: c! | B -> B; sync: c?", "R: A -> B; guard: false; sync: c?"), ["S.A>B"]),
    ("receivers with several enabled edges choose one each",
     ("broadcast chan c;", "S: A -> B; sync: c!", "R(const int[0, 1] i): A -> A; sync: c? | A -> B; sync: c?"),
     [f"S.A>B + R(0).A>{first} + R(1).A>{second}" for first in "AB" for second in "AB"]),
    ("two committed processes interleave", ("", "P(const int[0, 1] i): committed: A | A -> B"),
     ["P(0).A>B", "P(1).A>B"]),
    ("a channel is chosen only where the guard holds",
     ("chan c[2]; int i = 2;", "S: A -> B; guard: i < 2; sync: c[i]! | A -> A; sync: c[0]!",
      "R: A -> B; guard: i < 2; sync: c[i]? | A -> A; sync: c[0]?"),
     ["S.A>A + R.A>A"]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("model", "expected"), [each[1:] for each in TRANSITIONS], ids=[each[0] for each in TRANSITIONS]
)
def test_transitions_of_the_initial_state(model, expected):
    made = network_of(*model)
    assert names(made, Semantics(made).transitions(made.initial)) == expected


def test_every_receiver_of_a_broadcast_with_an_enabled_edge_must_join():
    network = load(f"""broadcast chan c; int a;
        process S() {{ {IDLE} A -> B {{ sync c!; }}; }}
        process R(const int[0, 3] i) {{ {IDLE} A -> B {{ guard i > a; sync c?; }}; }}
        system S, R;""")
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    assert names(network, [transition]) == ["S.A>B + R(1).A>B + R(2).A>B + R(3).A>B"]
    assert after(network, transition).state.locations == (1, 0, 1, 1, 1)


def test_guards_are_evaluated_before_any_update():
    network = load(f"""broadcast chan c; int a, b;
        process S() {{ {IDLE} A -> B {{ sync c!; assign a = 1; }}; }}
        process R() {{ {IDLE} A -> B {{ guard a == 0; sync c?; assign b = 1 }}, A -> A {{ guard a == 1; sync c?;
            assign b = 2 }}; }} system R, S;""")
    (transition,) = Semantics(network).transitions(network.initial)
    assert after(network, transition).state.values[network.offset("b")] == 1


def test_the_sender_updates_first_then_the_receivers_in_system_order():
    network = load(f"""broadcast chan c; int[0, 9999] trail;
        process S() {{ {IDLE} A -> B {{ sync c!; assign trail = trail * 10 + 7; }}; }}
        process R(const int[1, 3] i) {{ {IDLE} A -> B {{ sync c?; assign trail = trail * 10 + i }}; }}
        X = R(2); Y = R(3); Z = R(1);
        system X, S, Z, Y;""")
    (transition,) = Semantics(network).transitions(network.initial)
    assert after(network, transition).state.values[network.offset("trail")] == 7213


def test_only_transitions_with_a_committed_participant_happen():
    network = load(f"""chan c; broadcast chan d, e;
        process P() {{ state A, B; commit A; init A; trans A -> B {{ sync c?; }}, A -> B {{ sync d?; }}; }}
        process Q() {{ {IDLE} A -> B {{ }}, A -> B {{ sync c!; }}, A -> A {{ sync d!; }}, A -> A {{ sync e!; }}; }}
        process R() {{ {IDLE} A -> A {{ sync c?; }}; }} system P, Q, R;""")
    semantics = Semantics(network)
    assert names(network, semantics.transitions(network.initial)) == ["Q.A>B + P.A>B", "Q.A>A + P.A>B"]
    assert semantics.committed(network.initial)
    assert not semantics.may_delay(network.initial)


def test_urgent_locations_stop_time_only():
    network = load(f"""process P() {{ state A, B; urgent A; init A; trans A -> B {{ }}; }}
        process Q() {{ {IDLE} A -> B {{ }}; }} system P, Q;""")
    semantics = Semantics(network)
    assert names(network, semantics.transitions(network.initial)) == ["P.A>B", "Q.A>B"]
    assert not semantics.may_delay(network.initial)
    assert semantics.may_delay(semantics.fire(network.initial, network.processes[0].edges).state)


@pytest.mark.parametrize(
    ("channel", "guard", "receiver", "may_delay"),
    [
        ("urgent chan", "true", "true", False),
        ("urgent chan", "a == 1", "true", True),
        ("urgent chan", "true", "a == 1", True),
        ("urgent broadcast chan", "true", "a == 1", False),  # a broadcast waits for nobody
        ("broadcast chan", "true", "true", True),
    ],
)
def test_an_enabled_synchronisation_on_an_urgent_channel_stops_time(channel, guard, receiver, may_delay):
    network = load(f"""{channel} c; int a; process P() {{ {IDLE} A -> B {{ guard {guard}; sync c!; }}; }}
        process Q() {{ {IDLE} A -> B {{ guard {receiver}; sync c?; }}; }} system P, Q;""")
    assert Semantics(network).may_delay(network.initial) is may_delay


def test_channels_chosen_at_run_time():
    network = load(f"""chan c[3]; int[0, 2] i = 2;
        process S() {{ {IDLE} A -> B {{ sync c[i]!; }}; }}
        process R(const int[0, 2] n) {{ {IDLE} A -> B {{ sync c[n]?; }}; }}
        process D() {{ {IDLE} A -> B {{ sync c[2 - i]?; }}, A -> A {{ sync c[i]?; }}; }} system S, R, D;""")
    assert names(network, Semantics(network).transitions(network.initial)) == [
        "S.A>B + R(2).A>B",
        "S.A>B + D.A>A",
    ]
    (edge,) = network.processes[0].edges
    assert [network.channels[number].name for number in edge.channels] == ["c[0]", "c[1]", "c[2]"]


def test_clock_guards_stay_symbolic_and_are_evaluated_in_the_state_before():
    network = load(f"""const int T[2] = {{5, 9}}; clock x, ys[2]; int i = 1; chan c;
        process P() {{ clock z; {IDLE} A -> B {{ guard x >= T[i] && 3 < ys[i] && i == 1 && z <= 7; sync c!;
            assign i = 0, x = 0, ys[i] = 4, ys[1] = i }}; }}
        process Q() {{ {IDLE} A -> B {{ guard T[0] >= x; sync c?; }}; }} system P, Q;""")
    assert network.clocks == ("0", "x", "ys[0]", "ys[1]", "P.z")
    (transition,) = Semantics(network).transitions(network.initial)
    assert transition.bounds == ((1, ">=", 9), (3, ">", 3), (4, "<=", 7), (1, "<=", 5))
    assert after(network, transition).resets == ((1, 0), (2, 4), (3, 0))
    (edge,) = network.processes[0].edges
    assert edge.resets == {1, 3}  # ys[i] may be any
    bound = edge.guard.clocks[0]
    assert (bound.low, bound.high, list(bound.clocks)) == (5, 9, [1])
    assert list(edge.guard.clocks[1].clocks) == [2, 3]


def test_a_bound_is_evaluated_only_where_the_data_guard_holds():
    network = load(f"""const int T[2] = {{5, 9}}; clock x; int i = 2;
        process P() {{ {IDLE} A -> B {{ guard x >= T[i] && i < 2; }}; }} system P;""")
    assert list(Semantics(network).transitions(network.initial)) == []


def test_forall_over_clocks_is_a_conjunction():
    network = load("""clock x[3]; process P() { state A { forall (i : int[0, 2]) x[i] <= i + 1 }, B; init A; trans
        A -> B { guard forall (i : int[0, 2]) (x[i] >= i && i != 5); }; } system P;""")
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    assert transition.bounds == ((1, ">=", 0), (2, ">=", 1), (3, ">=", 2))
    assert semantics.invariant(network.initial) == [(1, "<=", 1), (2, "<=", 2), (3, "<=", 3)]


def test_an_invariant_follows_the_values():
    network = load(f"""clock x; int a = 4; process P() {{ state A {{ x <= a + 1 && a < 9 }}, B; init A; trans
        A -> A {{ assign a = 8 }}, A -> A {{ assign a = 9 }}; }} process Q() {{ {IDLE} A -> A {{ }}; }} system P, Q;""")
    semantics = Semantics(network)
    assert semantics.invariant(network.initial) == [(1, "<=", 5)]
    eight, nine, _ = (after(network, t).state for t in semantics.transitions(network.initial))
    assert semantics.invariant(eight) == [(1, "<=", 9)]
    assert [semantics.allowed(state) for state in (network.initial, eight, nine)] == [True, True, False]


def test_an_assignment_out_of_range_is_an_error_not_a_disabled_edge():
    network = load(f"int[0, 1] a; process P() {{ {IDLE} A -> B {{ assign a = a + 2 }}; }} system P;")
    semantics = Semantics(network)
    (transition,) = semantics.transitions(network.initial)
    with pytest.raises(RangeError, match=r"a = 2 is out of its range \[0,1\]"):
        semantics.fire(network.initial, transition.edges)


def test_values_are_integers_whatever_was_computed():
    network = load(f"""bool p; int n; process P() {{ {IDLE}
        A -> B {{ assign p = n == 0, n = p && true, n = n + (n == 1) }}; }} system P;""")
    (transition,) = Semantics(network).transitions(network.initial)
    values = after(network, transition).state.values
    assert values == (1, 2)
    assert [type(value) for value in values] == [int, int]


def test_a_part_of_the_processes_moves_alone():
    network = load(f"""chan c; broadcast chan d;
        process P() {{ {IDLE} A -> B {{ sync c!; }}, A -> B {{ sync d!; }}; }}
        process Q() {{ state A, B; commit A; init A; trans A -> B {{ sync c?; }}, A -> B {{ sync d?; }}; }}
        system P, Q;""")
    assert names(network, Semantics(network, [0]).transitions(network.initial)) == ["P.A>B"]
    (received,) = Semantics(network, [1]).received(network.initial, 1)
    assert names(network, [received]) == ["Q.A>B"]


def test_a_sender_of_the_environment_writes_between_guards_and_updates():
    network = load(f"""broadcast chan c; int level, seen; process P() {{ {IDLE} A -> B {{ guard level == 0; sync c?;
        assign seen = level }}; }} system P;""")
    semantics = Semantics(network)
    (transition,) = semantics.received(network.initial, 0)
    assert semantics.fire(network.initial, transition.edges, {0: 3}).state.values == (3, 3)


# Templates: parameters by value and by reference, partial instantiation, free parameters, select.


def all_values(network):
    return dict(zip(network.offsets, network.initial.values, strict=True))


def test_free_parameters_make_a_process_for_each_value():
    network = load("""const int N = 3; typedef int[0, N - 1] id_t;
        process A(const id_t id, bool flag) { int own = id; state S; init S; } process B() { state S; init S; }
        system B, A;""")
    assert [process.name for process in network.processes] == [
        "B", "A(0,0)", "A(0,1)", "A(1,0)", "A(1,1)", "A(2,0)", "A(2,1)"
    ]  # fmt: skip
    assert all_values(network)["A(2,1).own"] == 2
    assert {process.template for process in network.processes} == {"A", "B"}


def test_the_number_of_processes_follows_a_given_constant():
    text = """const int N = 3; typedef int[0, N - 1] id_t; int level[id_t];
        process A(const id_t id) { state S; init S; } system A;"""
    assert len(load(text).processes) == 3
    network = load(text, N=5)
    assert [process.name for process in network.processes] == [f"A({n})" for n in range(5)]
    assert len(network.offsets) == 5


def test_partial_instantiation():
    network = load("""int a[2] = {7, 8};
        process T(const int n, int &where, const int list[2]) { int own = n + list[1]; state S; init S; trans
            S -> S { assign where = n }; }
        const int L[2] = {10, 20};
        X(const int[0, 1] i) = T(i + 5, a[0], L); Y = T(9, a[1], L); Z = X(1);
        system X, Y, Z;""")
    assert [process.name for process in network.processes] == ["X(0)", "X(1)", "Y", "Z"]
    assert all_values(network) == {
        "a[0]": 7, "a[1]": 8, "X(0).own": 25, "X(1).own": 26, "Y.own": 29, "Z.own": 26,
    }  # fmt: skip
    semantics = Semantics(network)
    states = [semantics.fire(network.initial, t.edges).state for t in semantics.transitions(network.initial)]
    assert [state.values[:2] for state in states] == [(5, 8), (6, 8), (7, 9), (6, 8)]


def test_references_to_clocks_and_channels():
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


def test_a_reference_to_a_constant_cannot_be_assigned():
    with pytest.raises(ModelError, match="'N' is a number"):
        load("const int N = 3; process T(int &n) { state S; init S; } A = T(N); system A;")
    with pytest.raises(ModelError, match="'a' is constant and cannot be assigned"):
        load("""int a; process T(const int &where) { state S; init S; trans S -> S { assign where = 1 }; }
            A = T(a); system A;""")


def test_select_makes_an_edge_for_each_value():
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


def test_local_names_hide_global_ones():
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
