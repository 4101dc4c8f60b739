"""Execution in virtual time: what is taken when, in which order, how late, and what passes to the environment."""

import pytest

from end_effector_hal.errors import ModelError, RangeError, UsageError
from tests.unit.timed_automata.explore.models import load, network, pointed
from timed_automata import Change, Event, Execution

MS = 1000

# A step that is activated, waits 5 s for its confirmation, and starts again 1 s later.
RETRY = """
const int TIMEOUT = 5000, RESET = 1000, D = 50;
broadcast chan start, confirmed, cancel, activate, deactivate;
int[0, 3] evidence; bool valve; int[0, 9] attempts; clock t;
process Step() {
    state Off, On { t <= TIMEOUT + D }, Reset { t <= RESET + D }, Done; init Off; trans
    Off -> On { guard evidence == 0; sync start?; assign attempts = 1, valve = true, t = 0 },
    On -> Done { sync confirmed?; assign valve = evidence == 3 },
    On -> Reset { guard t >= TIMEOUT; sync deactivate!; assign valve = false, t = 0 },
    Reset -> On { guard t >= RESET; sync activate!; assign attempts++, valve = true, t = 0 },
    On -> Off { sync cancel?; assign valve = false };
}
process World() { state A; init A; trans A -> A { sync start! }, A -> A { sync confirmed!; assign evidence = 3 },
    A -> A { sync cancel! }; }
system Step, World;
"""


@pytest.fixture
def step():
    execution = Execution(load(RETRY), ["Step"], ["evidence"])
    assert execution.start(1_000_000) == ()
    return execution


def edges(steps):
    return [f"{edge.process}.{edge.source}>{edge.target}" for step in steps for edge in step.edges]


def test_an_input_is_taken_and_a_deadline_follows(step):
    assert step.deadline is None
    reaction = step.receive(Event("start"), 1_200_000)
    assert reaction.taken
    (taken,) = reaction.steps
    assert (taken.at, taken.due, taken.late_us, taken.missed) == (1_200_000, None, 0, False)
    assert (taken.received, taken.sent) == ("start", None)
    assert taken.changes == (Change("valve", 0, 1), Change("attempts", 0, 1))
    assert [(edge.process, edge.source, edge.target, edge.index) for edge in taken.edges] == [
        ("Step", "Off", "On", 0)
    ]
    assert (step.deadline, step.location("Step"), step.value("valve")) == (6_200_000, "On", 1)


def test_a_time_out_is_never_early_and_exact_in_virtual_time(step):
    step.receive(Event("start"), 1_200_000)
    assert step.advance(6_199_999) == ()
    assert step.deadline == 6_200_000
    (taken,) = step.advance(6_200_000)
    assert (taken.at, taken.due, taken.late_us, taken.missed) == (6_200_000, 6_200_000, 0, False)
    assert (taken.sent, taken.received) == ("deactivate", None)
    assert step.deadline == 7_200_000


def test_lateness_is_reported_and_the_next_wait_begins_when_the_edge_is_taken(step):
    step.receive(Event("start"), 1_200_000)
    (taken,) = step.advance(6_230_000)
    assert (taken.at, taken.due, taken.late_us, taken.missed) == (6_230_000, 6_200_000, 30_000, False)
    assert step.deadline == 7_230_000  # one second after it was really taken


def test_beyond_the_reaction_bound_it_is_taken_and_reported(step):
    step.receive(Event("start"), 1_200_000)
    (taken,) = step.advance(6_250_000)
    assert (taken.late_us, taken.missed) == (50 * MS, False)  # exactly D
    (taken,) = step.advance(8_250_000 + 1)
    assert (taken.late_us, taken.missed) == (1_000_001, True)


def test_an_event_before_a_time_out_of_the_same_instant(step):
    step.receive(Event("start"), 1_200_000)
    reaction = step.receive(Event("confirmed", {"evidence": 3}), 6_200_000)
    assert edges(reaction.steps) == ["Step.On>Done"]
    assert step.advance(6_200_000) == ()


def test_a_time_out_that_is_due_before_an_event_comes_first(step):
    step.receive(Event("start"), 1_200_000)
    reaction = step.receive(Event("confirmed", {"evidence": 3}), 6_200_001)
    assert not reaction.taken
    assert edges(reaction.steps) == ["Step.On>Reset"]
    assert (reaction.steps[0].at, reaction.steps[0].late_us) == (6_200_001, 1)
    assert step.value("evidence") == 3  # a level stays, whether its event is taken or not


def test_an_untaken_event_of_the_same_instant_leaves_the_time_out_for_advance(step):
    step.receive(Event("start"), 1_200_000)
    reaction = step.receive(Event("start"), 6_200_000)
    assert (reaction.taken, reaction.steps) == (False, ())
    assert step.deadline == 6_200_000
    assert edges(step.advance(6_200_000)) == ["Step.On>Reset"]


def test_an_event_writes_after_the_guards_and_before_the_updates(step):
    step.receive(Event("start", {"evidence": 2}), 1_200_000)  # the guard saw 0
    assert step.location("Step") == "On"
    (taken,) = step.receive(Event("confirmed", {"evidence": 3}), 1_300_000).steps
    assert Change("evidence", 2, 3) in taken.changes
    assert step.value("valve") == 1  # evidence == 3 in the update


def test_time_does_not_run_back(step):
    step.receive(Event("start"), 2_000_000)
    (taken,) = step.receive(Event("cancel"), 1_500_000).steps
    assert taken.at == 2_000_000


def test_run_goes_from_deadline_to_deadline(step):
    step.receive(Event("start"), 1_000_000)
    steps = step.run(19_000_000)
    assert [(taken.at, taken.sent) for taken in steps] == [
        (6_000_000, "deactivate"), (7_000_000, "activate"), (12_000_000, "deactivate"),
        (13_000_000, "activate"), (18_000_000, "deactivate"), (19_000_000, "activate"),
    ]  # fmt: skip
    assert not any(taken.late_us for taken in steps)


def test_an_assignment_out_of_range_is_told_when_it_happens():
    text = RETRY.replace("int[0, 9] attempts", "int[0, 2] attempts")
    execution = Execution(load(text), ["Step"], ["evidence"])
    execution.start(0)
    execution.receive(Event("start"), 0)
    execution.run(11_999_999)
    with pytest.raises(RangeError, match=r"attempts = 3 is out of its range \[0,2\]"):
        execution.run(12_000_000)


def test_bad_inputs_are_refused(step):
    with pytest.raises(UsageError, match=r"'confirme' is not one of its inputs\. Did you mean 'confirmed'\?"):
        step.receive(Event("confirme"), 0)
    with pytest.raises(UsageError, match="'activate' is sent by the executed processes"):
        step.receive(Event("activate"), 0)
    with pytest.raises(UsageError, match=r"no variable 'evidense'\. Did you mean 'evidence'\?"):
        step.receive(Event("confirmed", {"evidense": 1}), 0)
    with pytest.raises(UsageError, match="'valve' is not an interface variable"):
        step.write({"valve": 1})
    with pytest.raises(UsageError, match="evidence = 4 is no integer from 0 to 3"):
        step.write({"evidence": 4})
    with pytest.raises(UsageError, match=r"evidence = 1\.5 is no integer"):
        step.write({"evidence": 1.5})
    with pytest.raises(UsageError, match=r"no process 'Stp'\. Did you mean 'Step'\?"):
        step.location("Stp")
    with pytest.raises(UsageError, match="started already"):
        step.start(0)


def test_nothing_happens_before_the_start():
    execution = Execution(load(RETRY), ["Step"], ["evidence"])
    assert execution.deadline is None
    for call in (
        lambda: execution.advance(0),
        lambda: execution.receive(Event("start"), 0),
        lambda: execution.write({}),
        lambda: execution.run(0),
    ):
        with pytest.raises(UsageError, match="not started"):
            call()


def test_inputs_and_outputs(step):
    assert step.inputs == {"start", "confirmed", "cancel"}
    assert step.outputs == {"activate", "deactivate"}


# What may pass between the executed processes and their environment.


def sides(declarations, ours, theirs, interface=()):
    return Execution(network(declarations, f"P: {ours}", f"E: {theirs}"), ["P"], interface)


QUIET = "locations: A"


@pytest.mark.parametrize(
    ("ours", "theirs", "name"),
    [
        ("do: a = 1", "guard: a == 1", "a"),  # written here, read there
        ("guard: a == 1", "do: a = 1", "a"),
        ("do: a = 1", "do: a = 2", "a"),
        ("do: set()", "guard: a == 1", "a"),  # through a function
        ("guard: list[a] == 1", "do: list[1] = 2", "list"),
        ("sync: c[a]!", "do: a = 1", "a"),  # in the index of a channel
        ("guard: x >= a", "do: a = 1", "a"),  # in a bound
        ("guard: x >= 1", "do: x = 0", "x"),  # a clock
        ("do: x = 0", "guard: x >= 1", "x"),
    ],
)
def test_a_shared_variable_must_be_interface(ours, theirs, name):
    declarations = "int a, list[3]; clock x; broadcast chan c[3]; void set() { a = 1; }"
    edges_ = f"A -> A; {ours}", f"A -> A; {theirs}"
    with pytest.raises(ModelError, match=f"share '{name}' with the environment, but not as interface"):
        sides(declarations, *edges_)
    if name != "x":
        sides(declarations, *edges_, [name])


def test_what_only_one_side_touches_and_what_both_only_read_is_free():
    edge = "A -> A; guard: both == 1 && {0} > 1; do: {1} = 1, {0} = 0"
    sides("int a, b, both; clock x, y;", edge.format("x", "a"), edge.format("y", "b"))


def test_names_that_do_not_exist():
    told = r"interface variable 'evidense' is not in the network\. Did you mean 'evidence'\?"
    with pytest.raises(UsageError, match=told):
        sides("int evidence;", QUIET, QUIET, ["evidense"])


@pytest.mark.parametrize(("ours", "other"), ["!?", "?!"])
def test_binary_channels_do_not_cross(ours, other):
    for theirs in (f"A -> A; sync: c{other}", QUIET):
        with pytest.raises(ModelError, match="Both ends of the binary channel 'c' must be executed"):
            sides("chan c;", f"A -> A; sync: c{ours}", theirs)


def test_a_broadcast_channel_has_its_senders_on_one_side():
    with pytest.raises(ModelError, match="Both sides send on the broadcast channel 'c'"):
        sides("broadcast chan c;", "A -> A; sync: c!", "A -> A; sync: c!")


def test_equality_on_a_clock_cannot_be_executed():
    equal = "A -> A; guard: x == 3 && true"
    with pytest.raises(ModelError, match="'x == 3' cannot be executed") as error:
        sides("clock x;", equal, QUIET)
    assert pointed(error.value).startswith("x == 3")
    sides("clock x;", QUIET, equal)  # the environment may


def test_invariants_about_data_cannot_be_executed():
    with pytest.raises(ModelError, match="an executed location whose invariant is about data"):
        sides("int a;", "locations: A | A: a == 0", QUIET)
