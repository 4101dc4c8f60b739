"""What an execution does is a run of its network; whatever is changed in the record of it is objected to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from end_effector_hal.errors import ModelError
from tests.support.nightly import examples
from tests.unit.timed_automata.explore.random_networks import networks
from timed_automata import Change, Event, Execution, Received, Step, Written, load_network
from timed_automata.monitor import Monitor

MODEL = Path(__file__).parents[1] / "models" / "two_steps.xml"
SIDE = (["Sequence", "Step"], ["evidence"])
EVENTS = ["begin", "stop", "confirmed[0]", "confirmed[1]", "gone[0]", "gone[1]"]


@pytest.fixture(scope="module")
def model():
    return load_network(MODEL)


def event(name):
    """An event of the world, with the level that belongs to it."""
    index = name[-2:-1]
    return Event(name, {f"evidence[{index}]": int(name.startswith("confirmed"))} if index.isdigit() else {})


def observed(model, inputs, until, late=()):
    """What is seen of an execution: events at their times, time-outs as late as asked."""
    seen = []
    execution = Execution(model, *SIDE, observe=seen.append)
    execution.start(0)
    late = list(late)
    for at, name in inputs:
        while (due := execution.deadline) is not None and due < at:
            execution.advance(min(due + (late.pop(0) if late else 0), at - 1))
        execution.receive(event(name), at)
    execution.run(until)
    return seen


def objections(model, seen, until):
    monitor = Monitor(model, *SIDE)
    for observation in seen:
        monitor.observe(observation)
    monitor.end(until)
    return monitor.objections


INPUTS = [(0, "begin"), (20_000, "confirmed[0]"), (85_000, "stop")]


@pytest.fixture
def seen(model):
    """The first step is confirmed, the second times out at 70 ms, is tried again at 80 ms and stopped at 85 ms."""
    found = observed(model, INPUTS, 200_000)
    steps = {step.at for step in found if isinstance(step, Step)}
    assert steps == {0, 20_000, 70_000, 80_000, 85_000}
    assert objections(model, found, 200_000) == []
    return found


def test_what_is_left_out_is_missed(model, seen):
    """Every single observation matters."""
    for number in range(len(seen)):
        cut = [*seen[:number], *seen[number + 1 :]]
        assert objections(model, cut, 200_000), seen[number]


def test_a_step_at_another_time_is_no_step(model, seen):
    number = next(i for i, step in enumerate(seen) if isinstance(step, Step) and step.at == 70_000)
    step = seen[number]
    for at in (69_999, 75_001):
        moved = [*seen[:number], replace(step, at=at, late_us=at - 70_000), *seen[number + 1 :]]
        found = objections(model, moved, 200_000)
        assert found[0].at == at
        assert ("before its time" if at < 70_000 else "after its time") in found[0].what


def test_a_missed_bound_that_is_told_is_told_on(model):
    inside = observed(model, [(0, "begin"), (90_000, "stop")], 90_000, [5_000])
    assert objections(model, inside, 90_000) == []
    late = observed(model, [(0, "begin"), (90_000, "stop")], 90_000, [5_001])
    (found,) = objections(model, late, 90_000)
    assert (found.at, found.kind) == (55_001, "missed")
    assert "5.001 ms late" in found.what


def test_what_is_not_told_as_late_is_objected_to(model):
    late = observed(model, [(0, "begin"), (90_000, "stop")], 90_000, [5_001])
    hidden = [replace(o, missed=False) if isinstance(o, Step) else o for o in late]
    assert [o.kind for o in objections(model, hidden, 90_000)][:1] == ["no run"]


def test_another_change_another_edge_another_channel(model, seen):
    number = next(i for i, step in enumerate(seen) if isinstance(step, Step) and step.changes)
    step = seen[number]
    edge = replace(step.edges[0], index=step.edges[0].index + 1)
    for other in (
        replace(step, changes=(*step.changes, Change("done", 0, 1))),
        replace(step, changes=()),
        replace(step, edges=(edge, *step.edges[1:])),
        replace(step, edges=step.edges[:1]) if len(step.edges) > 1 else replace(step, edges=()),
        replace(step, received="stop"),
        replace(step, sent="activate[1]"),
    ):
        found = objections(model, [*seen[:number], other, *seen[number + 1 :]], 200_000)
        assert found, other
        assert found[0].at == step.at


def test_the_edges_that_a_step_names_are_not_believed(model, seen):
    """Whatever they say, the run is followed as the network goes on, and each is objected to."""
    for number, step in enumerate(seen):
        if not isinstance(step, Step):
            continue
        for key, value in (("source", "x"), ("target", "x"), ("index", 99), ("index", -1), ("process", "x")):
            false = replace(step, edges=(replace(step.edges[0], **{key: value}), *step.edges[1:]))
            monitor = Monitor(model, *SIDE)
            for observation in [*seen[:number], false, *seen[number + 1 :]]:
                monitor.observe(observation)
            monitor.end(200_000)
            assert {(each.at, each.kind) for each in monitor.objections} == {(step.at, "no run")}
            assert monitor.steps == sum(isinstance(each, Step) for each in seen)


def test_another_edge_that_does_the_same_is_not_followed(tmp_path):
    path = tmp_path / "model.xml"
    path.write_text(
        """<nta><template><name>P</name><location id="a"><name>A</name><urgent/></location>
        <location id="b"><name>B</name></location><location id="c"><name>C</name></location><init ref="a"/>
        <transition><source ref="a"/><target ref="b"/></transition>
        <transition><source ref="a"/><target ref="c"/></transition></template><system>system P;</system></nta>""",
        encoding="utf-8",
    )
    made, seen = load_network(path), []
    Execution(made, ["P"], observe=seen.append).start(0)
    step = seen[-1]
    assert step.edges[0].target == "B"
    other = replace(step, edges=(replace(step.edges[0], target="C", index=1),))
    monitor = Monitor(made, ["P"])
    for observation in [*seen[:-1], other]:
        monitor.observe(observation)
    (found,) = monitor.objections
    assert found.what == "P A → C is recorded, but P A → B comes first, and has the recorded effect."
    assert monitor.snapshot.locations == {"P": "B"}


def test_what_is_due_and_late_is_recorded_as_it_was(model, seen):
    for number, step in enumerate(seen):
        if isinstance(step, Step):
            for changes in (
                {"due": None if step.due is not None else step.at},
                {"late_us": 10**400},
                {"due": 0},
            ):
                if replace(step, **changes) == step:
                    continue
                false = [*seen[:number], replace(step, **changes), *seen[number + 1 :]]
                assert [each.kind for each in objections(model, false, 200_000)] == ["no run"], (
                    step,
                    changes,
                )


def test_time_does_not_run_backwards(model, seen):
    number = next(i for i, o in enumerate(seen) if isinstance(o, Received) and o.at == 85_000)
    turned = [*seen[:number], replace(seen[number], at=1), *seen[number + 1 :]]
    assert "backwards" in objections(model, turned, 200_000)[0].what


def test_a_deadline_that_passes_without_a_step(model):
    seen = observed(model, [(0, "begin")], 10_000)
    assert objections(model, seen, 55_000) == []
    (found,) = objections(model, seen, 55_001)
    assert "A deadline has passed" in found.what


def test_an_event_that_nobody_took_although_somebody_could(model):
    seen = observed(model, [(0, "begin")], 10_000)
    (found,) = objections(model, [*seen, Received(20_000, "stop", {})], 30_000)
    assert "'stop' was lost" in found.what


def test_a_level_that_was_written_counts(model, seen):
    """Without the event that belongs to it: the step that follows is not that of the network any more."""
    assert objections(model, [*seen[:1], Written(0, {"evidence[0]": 1}), *seen[1:]], 200_000)


gaps = st.integers(0, 3_000) | st.sampled_from([0, 1, 999, 1_000, 1_001, 10_000, 50_000, 60_000])


@settings(max_examples=examples(33, 2000), deadline=None)
@given(
    gaps=st.lists(st.tuples(gaps, st.sampled_from(EVENTS)), max_size=25),
    late=st.lists(st.sampled_from([0, 1, 4_999, 5_000, 5_001, 40_000]), max_size=25),
)
def test_every_execution_is_a_run_however_late(model, gaps, late):
    inputs, at = [], 0
    for gap, name in gaps:
        at += gap
        inputs.append((at, name))
    seen = observed(model, inputs, at + 300_000, late)
    found = objections(model, seen, at + 300_000)
    assert all(objection.kind == "missed" for objection in found)
    assert len(found) == sum(step.missed for step in seen if isinstance(step, Step))


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    model=networks(executable=True), late=st.lists(st.sampled_from([0, 0, 1, 999, 1000, 5000]), max_size=12)
)
def test_executions_of_random_networks_are_runs_of_them(model, late):
    """All of it executed: no environment, so that only time and order are at stake."""
    seen = []
    try:
        execution = Execution(model, ["P0", "P1"], observe=seen.append)
    except ModelError:
        return  # an equation with a clock: no machine hits an instant
    monitor = Monitor(model, ["P0", "P1"])
    try:
        execution.start(0)
        at = 0
        for lateness in late:
            at = (execution.deadline if execution.deadline is not None else at) + lateness
            execution.advance(at)
    except ModelError:
        pass  # stuck or out of range: what was done before is a run all the same
    for observation in seen:
        monitor.observe(observation)
    assert [o for o in monitor.objections if o.kind != "missed"] == []


AT_ONE_INSTANT = """<nta><declaration>clock x; bool told; broadcast chan on;</declaration><template><name>P</name>
<location id="a"/><location id="b"/><location id="c"/><init ref="a"/>
<transition><source ref="a"/><target ref="b"/><label kind="guard">x &gt;= 2</label></transition>
<transition><source ref="a"/><target ref="c"/><label kind="synchronisation">on!</label>
<label kind="guard">told</label></transition>
</template><system>system P;</system></nta>"""


@pytest.mark.parametrize(("told_us", "target"), [(2_000, "c"), (1_999, "c"), (2_001, "b")])
def test_what_an_event_allows_may_come_before_a_bound_of_the_same_instant(tmp_path, told_us, target):
    """The executor takes what is at its bound when all events of the instant have come."""
    path = tmp_path / "model.xml"
    path.write_text(AT_ONE_INSTANT, encoding="utf-8")
    network, seen = load_network(path), []
    execution = Execution(network, ["P"], ["told"], observe=seen.append)
    execution.start(0)
    execution.advance(1_999)
    if told_us > 2_000:
        execution.advance(2_000)
    execution.write({"told": 1}, told_us)
    execution.advance(2_001)
    assert [edge.target for step in seen if isinstance(step, Step) for edge in step.edges] == [target]
    monitor = Monitor(network, ["P"], ["told"])
    for observation in seen:
        monitor.observe(observation)
    assert monitor.objections == []


def test_queries_with_their_clocks(tmp_path):
    path = tmp_path / "model.xml"
    path.write_text(
        """<nta><declaration>clock x; int v; int w;</declaration>
        <template><name>P</name><declaration>bool told() { return v &lt; 2; }
        bool quiet() { return w == 0; }</declaration>
        <location id="a"><name>a</name></location><location id="b"><name>b</name></location><init ref="a"/>
        <transition><source ref="a"/><target ref="b"/><label kind="guard">x &gt;= 2</label>
        <label kind="assignment">v = 1</label></transition></template>
        <template><name>Q</name><location id="c"/><init ref="c"/>
        <transition><source ref="c"/><target ref="c"/><label kind="assignment">w = 1</label></transition></template>
        <system>system P, Q;</system>
        <queries><query><formula>A[] P.b imply x &lt;= 3</formula><comment>[in-time] Soon.</comment></query>
        <query><formula>A[] P.b imply v == 1</formula><comment>[told] v tells.</comment></query>
        <query><formula>A[] w == 0</formula><comment>[theirs] Not about P.</comment></query>
        <query><formula>A[] P.told()</formula><comment>[asked] Of P, about v.</comment></query>
        <query><formula>A[] P.quiet()</formula><comment>[quiet] Of P, not about P.</comment></query>
        <query><formula>A[] Q.c</formula><comment>[there] Not about P.</comment></query>
        <query><formula>E&lt;&gt; P.b</formula><comment>[reach] No invariant.</comment></query></queries></nta>""",
        encoding="utf-8",
    )
    made, seen = load_network(path), []
    execution = Execution(made, ["P"], observe=seen.append)
    execution.start(0)
    execution.run(2_000)
    for end, broken in ((3_000, []), (3_001, ["[in-time] Soon."])):
        monitor = Monitor(made, ["P"], requirements=True)
        comments = [query.comment for query in monitor.queries]
        assert comments == ["[in-time] Soon.", "[told] v tells.", "[asked] Of P, about v."]
        for observation in seen:
            monitor.observe(observation)
        monitor.end(end)
        assert [(o.kind, o.what) for o in monitor.objections] == [
            ("requirement", f"Did not hold: {text}") for text in broken
        ]
