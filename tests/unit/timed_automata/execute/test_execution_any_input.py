"""Whatever comes in, whenever: an execution goes on, and how time is cut into calls does not matter."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.nightly import examples
from timed_automata import Event, Execution, load_network
from timed_automata.execute import _successors

MODEL = Path(__file__).parents[1] / "models" / "two_steps.xml"
EVENTS = ["begin", "stop", "confirmed[0]", "confirmed[1]", "gone[0]", "gone[1]"]


@pytest.fixture(scope="module")
def network():
    return load_network(MODEL)


def started(network):
    execution = Execution(network, ["Sequence", "Step"], ["evidence"])
    execution.start(0)
    return execution


def apply(execution, name, at):
    """An event of the world, with the level that belongs to it."""
    index = name[-2:-1]
    writes = {f"evidence[{index}]": int(name.startswith("confirmed"))} if index.isdigit() else {}
    return execution.receive(Event(name, writes), at)


def story(execution):
    return execution.state, execution.deadline


gaps = st.integers(0, 3_000) | st.sampled_from([0, 1, 999, 1_000, 1_001, 10_000, 50_000, 60_000])
inputs = st.lists(st.tuples(gaps, st.sampled_from(EVENTS)), max_size=25)


@settings(max_examples=examples(37, 3000), deadline=None)
@given(inputs=inputs, lateness=st.lists(gaps, min_size=25, max_size=25))
def test_random_events_at_random_times_never_raise(network, inputs, lateness):
    execution, at, last = started(network), 0, 0
    for (gap, name), late in zip(inputs, lateness, strict=False):
        at += gap
        for step in apply(execution, name, at).steps:
            assert last <= step.at == at or step.at == last
            assert step.due is None or step.late_us == step.at - step.due >= 0
            last = step.at
        at += late
        for step in execution.advance(at):
            assert step.at == at
            assert step.due is not None
            assert step.late_us == at - step.due >= 0
            last = at
        assert execution.deadline is None or execution.deadline > at
        assert not network.processes[0].locations[execution.state.locations[0]].committed
        assert execution.value("done") <= 2


@settings(max_examples=examples(37, 3000), deadline=None)
@given(inputs=inputs, cuts=st.lists(st.integers(0, 400_000), max_size=20), end=st.integers(0, 400_000))
def test_one_jump_equals_many_small_steps(network, inputs, cuts, end):
    """The same steps at the same times, however often time is told in between."""
    whole, cut = started(network), started(network)
    at, expected, found = 0, [], []
    for gap, name in inputs:
        at += gap
        for execution, steps in ((whole, expected), (cut, found)):
            if execution is cut:
                for moment in sorted(c for c in cuts if at - gap <= c < at):
                    steps += execution.run(moment)
            steps += execution.run(at - 1)
            steps += apply(execution, name, at).steps
        assert story(whole) == story(cut)
    expected += whole.run(at + end)
    for moment in sorted(at + c for c in cuts if c <= end):
        found += cut.run(moment)
    found += cut.run(at + end)
    assert found == expected
    assert story(whole) == story(cut)


@settings(max_examples=examples(20, 1000), deadline=None)
@given(inputs=inputs)
def test_the_same_inputs_give_the_same_steps(network, inputs):
    """Replay decides the same: nothing but the arguments goes in."""
    told = []
    for execution in (started(network), started(network)):
        at, steps = 0, []
        for gap, name in inputs:
            at += gap
            steps += execution.run(at - 1)
            steps += apply(execution, name, at).steps
        told.append((steps, story(execution)))
    assert told[0] == told[1]


@settings(max_examples=examples(25, 2000), deadline=None)
@given(inputs=inputs)
def test_every_trace_is_a_run_of_the_model(network, inputs):
    """Judged by a second reading of the model, by hand, that shares no code with the executor."""
    execution, at, steps = started(network), 0, []
    for gap, name in inputs:
        at += gap
        steps += execution.run(at - 1)
        steps += apply(execution, name, at).steps
    steps += execution.run(at + 500_000)
    zero, location = 0, {"Sequence": "Idle", "Step(0)": "Off", "Step(1)": "Off"}
    for step in steps:
        waited = step.at - zero
        for edge in step.edges:
            assert location[edge.process] == edge.source
            location[edge.process] = edge.target
        moves = {(edge.process, edge.source, edge.target) for edge in step.edges}
        if ("Sequence", "Wait", "Pause") in moves:
            assert (waited, step.sent) == (50_000, f"deactivate[{execution_index(step)}]")
        if ("Sequence", "Pause", "Start") in moves:
            assert waited == 10_000
        if any(target in ("Wait", "Pause") for _, _, target in moves):
            zero = step.at
        if ("Sequence", "Wait", "Idle") in moves:
            assert step.received == "stop"
        for name in ("Step(0)", "Step(1)"):
            if (name, "Pending", "On") in moves:
                assert step.received == f"confirmed[{name[5]}]"
    assert location["Sequence"] == execution.location("Sequence")


def execution_index(step):
    (index,) = {edge.process[5] for edge in step.edges if edge.process.startswith("Step")}
    return index


@settings(max_examples=examples(20, 1000), deadline=None)
@given(inputs=inputs)
def test_what_was_worked_out_before_changes_nothing(network, inputs):
    """An execution that remembers nothing does the same as one that has been everywhere."""
    remembers, forgets, at = started(network), started(network), 0
    remembers._successors = remembers._schedule._successors = WELL_TRAVELLED.setdefault(
        id(network), remembers._successors
    )
    for gap, name in inputs:
        at += gap
        forgets._successors.known.clear()
        forgets._successors._received.clear()
        assert apply(remembers, name, at) == apply(forgets, name, at)
        assert story(remembers) == story(forgets)
    assert remembers.advance(at + 100_000) == forgets.advance(at + 100_000)


def test_not_everything_is_remembered_for_ever(network, monkeypatch):
    monkeypatch.setattr(_successors, "MOST", 3)
    execution = started(network)
    for at, name in enumerate(EVENTS * 3):
        apply(execution, name, at * 1000)
    assert len(execution._successors.known) <= 3
    assert len(execution._successors._received) <= 3


WELL_TRAVELLED: dict = {}
