"""Whether something is a run of a network: guards, invariants, urgency and synchronisation, judged step by step.

Deliberately naive, with rational clocks: what it has in common with the simulator are the compiled expressions
and the rules of synchronisation.
"""

from __future__ import annotations

from fractions import Fraction
from operator import eq, ge, gt, le, lt

from end_effector_hal.automata import Semantics

OPS = {"<": lt, "<=": le, "==": eq, ">=": ge, ">": gt}


def holds(bounds, clocks):
    return all(OPS[bound.op](clocks[bound.clock], bound.value) for bound in bounds)


def assert_is_run(trace):
    """Every step is allowed when it is taken, and leads to the state that it says."""
    network = trace.network
    semantics = Semantics(network)
    state, now = network.initial, Fraction(0)
    clocks = [Fraction(0)] * len(network.clocks)
    assert holds(semantics.invariant(state), clocks)
    for step in trace.steps:
        assert step.at >= now
        assert step.at == now or semantics.may_delay(state), "time passed where it may not"
        clocks = [Fraction(0), *(clock + step.at - now for clock in clocks[1:])]
        now = step.at
        assert holds(semantics.invariant(state), clocks), "an invariant was left behind"
        (transition,) = [t for t in semantics.transitions(state) if t.edges == step.edges]
        assert holds(transition.bounds, clocks), "a guard does not hold"
        name = None if transition.channel is None else network.channels[transition.channel].name
        assert step.channel == name
        new, resets = semantics.fire(state, step.edges)
        assert step.state == new
        changed = {n: (state.values[at], new.values[at]) for n, at in network.offsets.items()}
        assert {c.name: (c.old, c.new) for c in step.changes} == {
            n: v for n, v in changed.items() if v[0] != v[1]
        }
        for clock, value in resets:
            clocks[clock] = Fraction(value)
        state = new
        assert semantics.allowed(state)
        assert holds(semantics.invariant(state), clocks), "the invariant of the target does not hold"
    assert trace.end >= now
