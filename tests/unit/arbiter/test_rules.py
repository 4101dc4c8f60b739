"""The rules of the line arbiter, in virtual time."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.arbiter import Exclusion, LineArbiter, Policy
from end_effector_hal.arbiter.protocol import LastWillRunsError
from end_effector_hal.arbiter.rules._state import ArbiterState
from end_effector_hal.errors import LineBusyError, LineRefusedError, UsageError, WireError
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import (
    BOTTOM,
    CYLINDER,
    GRIP,
    LINES,
    MS,
    POLICY,
    SENSING,
    TOKEN,
    TOP,
    UNLOCK,
    Lines,
    S,
)


class Arbiter:
    """The rules in virtual time, with two clients; between the steps it does what is due, when it is due."""

    def __init__(self, policy=POLICY, start=1 * S, **active):
        self.lines = Lines(**active)
        self.rules = LineArbiter(self.lines, policy, 0)
        self.now = 0
        self.alive = []
        self.to(start)
        self.lines.written.clear()
        self.grip = self.hello("grip", GRIP)
        self.changer = self.hello("changer", (UNLOCK,))

    def hello(self, client, lines, will=()):
        session = self.rules.hello(client, TOKEN, lines, will, self.now, pid=7)
        self.alive.append(session)
        return session

    def to(self, at):
        """Time passes; the living renew their leases."""
        while True:
            for session in self.alive:
                self.rules.renew(session, self.now)
            step = min(at, max(self.rules.deadline or at, self.now))
            step = min(step, self.now + 500 * MS)
            self.now = self.lines.now = step
            self.rules.advance(step)
            if step >= at:
                return

    def set(self, session, will=None, **levels):
        return self.rules.write(session, levels, will, self.now)

    def die(self, session):
        self.alive.remove(session)
        self.rules.declare_dead(session, "killed", self.now)

    @property
    def written(self):
        return self.lines.written


def test_a_write_is_applied_at_once_and_as_a_whole():
    arbiter = Arbiter()
    assert arbiter.set(arbiter.grip, bottom=True, top=True) == 0
    assert arbiter.written == [(1 * S, BOTTOM, True), (1 * S, TOP, True)]
    assert arbiter.rules.levels == {UNLOCK: False, BOTTOM: True, CYLINDER: False, TOP: True}


def test_writing_the_same_again_writes_nothing():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    assert arbiter.set(arbiter.grip, bottom=True) == 0
    assert len(arbiter.written) == 1


# IL-10


def test_il_10_a_second_change_waits_until_50_ms_are_over():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(1 * S + 10 * MS)
    assert arbiter.set(arbiter.grip, bottom=False) == 40 * MS
    assert arbiter.rules.deadline == 1 * S + 50 * MS
    arbiter.to(1 * S + 49 * MS)
    assert arbiter.rules.levels[BOTTOM]
    arbiter.to(2 * S)
    assert arbiter.written[1:] == [(1 * S + 50 * MS, BOTTOM, False)]


def test_il_10_what_comes_after_waits_behind_it():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, top=True, bottom=True)
    assert arbiter.set(arbiter.grip, top=False) == 50 * MS
    assert arbiter.set(arbiter.grip, cylinder=True) == 50 * MS
    assert arbiter.set(arbiter.grip, top=True) == 100 * MS
    assert arbiter.set(arbiter.changer, unlock=False) == 0
    arbiter.to(2 * S)
    assert arbiter.written[2:] == [
        (1 * S + 50 * MS, TOP, False),
        (1 * S + 50 * MS, CYLINDER, True),
        (1 * S + 100 * MS, TOP, True),
    ]


@pytest.mark.parametrize("end", ["write", "bye", "dead"])
def test_an_activation_that_waits_and_was_given_up_is_forgotten(end):
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(1 * S + 60 * MS)
    arbiter.set(arbiter.grip, bottom=False)
    arbiter.to(1 * S + 70 * MS)
    assert arbiter.set(arbiter.grip, bottom=True, top=True) == 40 * MS
    if end == "write":
        arbiter.set(arbiter.grip, bottom=False)
    elif end == "bye":
        arbiter.alive.remove(arbiter.grip)
        arbiter.rules.bye(arbiter.grip, (), arbiter.now)
    else:
        arbiter.die(arbiter.grip)
    arbiter.to(2 * S)
    assert arbiter.written[2:] == ([(1 * S + 70 * MS, TOP, True)] if end == "write" else [])


def test_il_10_holds_for_the_first_write_after_the_start():
    arbiter = Arbiter(start=20 * MS)
    assert arbiter.set(arbiter.grip, bottom=True) == 30 * MS
    assert arbiter.set(arbiter.grip, bottom=True) == 30 * MS


def test_il_10_bounded():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    for _ in range(64):
        arbiter.set(arbiter.grip, bottom=False)
    with pytest.raises(LineRefusedError, match="IL-10: 64 writes of this client wait"):
        arbiter.set(arbiter.grip, bottom=False)


# IL-01, IL-05


@pytest.mark.parametrize("line", GRIP)
def test_il_01_no_unlock_while_a_gripping_line_is_active(line):
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, **{line: True})
    with pytest.raises(LineRefusedError, match=rf"IL-01: unlock \(tool changer\) .* while {line} is active"):
        arbiter.set(arbiter.changer, unlock=True)
    arbiter.to(2 * S)
    arbiter.set(arbiter.grip, **{line: False})
    assert arbiter.set(arbiter.changer, unlock=True) == 0


@pytest.mark.parametrize("line", GRIP)
def test_il_05_no_gripping_while_unlocked(line):
    arbiter = Arbiter()
    arbiter.set(arbiter.changer, unlock=True)
    with pytest.raises(LineRefusedError, match="IL-05"):
        arbiter.set(arbiter.grip, **{line: True})
    assert arbiter.written == [(1 * S, UNLOCK, True)]


def test_ids_of_an_exclusion_can_be_named():
    policy = Policy(LINES, [Exclusion(BOTTOM, TOP, "IL-08", "IL-08")])
    arbiter = Arbiter(policy)
    with pytest.raises(LineRefusedError, match="IL-08"):
        arbiter.set(arbiter.grip, bottom=True, top=True)
    assert arbiter.written == []


def test_a_swap_in_one_write_is_no_violation():
    arbiter = Arbiter(Policy(LINES, [(BOTTOM, TOP)]))
    arbiter.set(arbiter.grip, bottom=True)
    assert arbiter.set(arbiter.grip, bottom=False, top=True) == 50 * MS
    arbiter.to(2 * S)
    assert arbiter.rules.levels == {UNLOCK: False, BOTTOM: False, CYLINDER: False, TOP: True}


def test_a_waiting_activation_excludes_already():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.set(arbiter.grip, bottom=False)
    arbiter.set(arbiter.grip, bottom=True)
    with pytest.raises(LineRefusedError):
        arbiter.set(arbiter.changer, unlock=True)


def test_an_activation_that_waits_while_the_line_is_inactive_excludes():
    arbiter = Arbiter()
    for level in (True, False, True):
        arbiter.set(arbiter.grip, bottom=level)
    arbiter.to(1 * S + 60 * MS)
    assert arbiter.rules.levels[BOTTOM] is False
    with pytest.raises(LineRefusedError, match="IL-01"):
        arbiter.set(arbiter.changer, unlock=True)


def test_an_adopted_violation_is_not_repeated():
    arbiter = Arbiter(unlock=True, bottom=True, policy=Policy(LINES, POLICY.exclusions))
    arbiter.set(arbiter.grip, cylinder=False, bottom=False)
    arbiter.set(arbiter.grip, top=False, bottom=False)
    with pytest.raises(LineRefusedError, match="IL-05"):
        arbiter.set(arbiter.grip, bottom=True)


def test_a_line_that_is_to_be_inactive_is_activated_only_by_the_rules():
    arbiter = Arbiter(unlock=True, bottom=True, start=20 * MS, policy=Policy(LINES, POLICY.exclusions))
    assert arbiter.set(arbiter.grip, bottom=False) == 30 * MS
    with pytest.raises(LineRefusedError, match="IL-05"):
        arbiter.set(arbiter.grip, bottom=True)


def test_a_waiting_deactivation_does_not_free_yet():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.set(arbiter.grip, bottom=False)
    with pytest.raises(LineRefusedError):
        arbiter.set(arbiter.changer, unlock=True)
    arbiter.to(1 * S + 50 * MS)
    assert arbiter.set(arbiter.changer, unlock=True) == 0


def test_an_adopted_violation_is_logged_and_can_be_written_as_it_is(caplog):
    arbiter = Arbiter(unlock=True, bottom=True, policy=Policy(LINES, POLICY.exclusions))
    assert "found active together" in caplog.text
    assert arbiter.set(arbiter.grip, bottom=True) == 0


# IL-03


def test_il_03_ends_an_activation_after_3_s():
    arbiter = Arbiter()
    arbiter.set(arbiter.changer, unlock=True)
    arbiter.to(3 * S)
    arbiter.set(arbiter.changer, unlock=True)
    arbiter.to(10 * S)
    assert arbiter.written == [(1 * S, UNLOCK, True), (4 * S, UNLOCK, False)]
    assert list(arbiter.rules.trips) == [(4 * S, UNLOCK)]


def test_il_03_counts_from_the_adoption():
    arbiter = Arbiter(unlock=True)
    arbiter.to(5 * S)
    assert arbiter.written == [(3 * S, UNLOCK, False)]


def test_il_03_that_fails_is_tried_again():
    arbiter = Arbiter()
    arbiter.set(arbiter.changer, unlock=True)
    arbiter.lines.error = OSError(5, "Input/output error")
    arbiter.to(5 * S)
    arbiter.lines.error = None
    arbiter.to(9 * S)
    assert arbiter.written == [(1 * S, UNLOCK, True), (7 * S, UNLOCK, False)]


# Wills

UNWIND = (
    LastWillStep(TOP, False, 0),
    LastWillStep(CYLINDER, False, 2 * S),
    LastWillStep(BOTTOM, False, 4 * S),
)


def gripped(will):
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, will, bottom=True, cylinder=True, top=True)
    arbiter.written.clear()
    arbiter.to(2 * S)
    return arbiter


def test_a_will_is_executed_in_order_and_in_time():
    arbiter = gripped(UNWIND)
    arbiter.die(arbiter.grip)
    arbiter.to(10 * S)
    assert arbiter.written == [(2 * S, TOP, False), (4 * S, CYLINDER, False), (6 * S, BOTTOM, False)]


def test_an_empty_will_holds():
    arbiter = gripped(())
    arbiter.die(arbiter.grip)
    arbiter.to(10 * S)
    assert arbiter.written == []
    assert arbiter.hello("grip", GRIP).client == "grip"


def test_the_last_will_counts_and_stays_until_the_next():
    arbiter = gripped(UNWIND)
    arbiter.set(arbiter.grip, ())
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.die(arbiter.grip)
    arbiter.to(10 * S)
    assert arbiter.written == []


def test_a_refused_write_leaves_the_will_as_it_was():
    arbiter = gripped(UNWIND)
    with pytest.raises(LineRefusedError):
        arbiter.rules.write(arbiter.changer, {UNLOCK: True}, (LastWillStep(UNLOCK),), arbiter.now)
    assert arbiter.changer.will == ()


def test_who_was_taken_for_dead_is_told_once():
    arbiter = Arbiter()
    assert not arbiter.grip.declared_dead
    arbiter.die(arbiter.grip)
    back = arbiter.hello("grip", GRIP)
    assert back.declared_dead
    arbiter.alive.remove(back)
    arbiter.rules.bye(back, (), arbiter.now)
    assert not arbiter.hello("grip", GRIP).declared_dead, "it left in order"


def test_the_will_of_a_hello_counts():
    arbiter = Arbiter(bottom=True)
    arbiter.die(arbiter.grip)
    arbiter.die(arbiter.hello("grip", GRIP, (LastWillStep(BOTTOM),)))
    assert arbiter.written == [(1 * S, BOTTOM, False)]


def test_a_will_keeps_il_10():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, (LastWillStep(TOP), LastWillStep(BOTTOM)), top=True)
    arbiter.die(arbiter.grip)
    arbiter.to(2 * S)
    assert arbiter.written == [(1 * S, TOP, True), (1 * S + 50 * MS, TOP, False)]


def test_a_death_cancels_waiting_activations_and_keeps_deactivations():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True, top=True)
    arbiter.set(arbiter.grip, bottom=False, cylinder=True)
    arbiter.set(arbiter.grip, (LastWillStep(CYLINDER),), bottom=True)
    arbiter.die(arbiter.grip)
    arbiter.to(3 * S)
    assert arbiter.written[2:] == [(1 * S + 50 * MS, BOTTOM, False)]


def test_hello_waits_for_the_end_of_a_will():
    arbiter = gripped(UNWIND)
    arbiter.die(arbiter.grip)
    arbiter.to(3 * S)
    for client, lines in (("grip", GRIP), ("other", (BOTTOM,))):
        with pytest.raises(LastWillRunsError, match="grip is being executed") as caught:
            arbiter.hello(client, lines)
        assert caught.value.retry_us == 3 * S
    arbiter.to(6 * S)
    assert arbiter.hello("grip", GRIP).client == "grip"


def test_no_unlock_while_a_will_is_not_over():
    arbiter = gripped(UNWIND)
    arbiter.die(arbiter.grip)
    arbiter.to(5 * S)
    with pytest.raises(LineRefusedError, match="IL-01"):
        arbiter.set(arbiter.changer, unlock=True)
    arbiter.to(6 * S)
    assert arbiter.set(arbiter.changer, unlock=True) == 0


def test_bye_executes_what_it_says_and_nothing_else():
    arbiter = gripped(UNWIND)
    arbiter.rules.bye(arbiter.grip, (LastWillStep(BOTTOM, False, 1 * S),), arbiter.now)
    arbiter.alive.remove(arbiter.grip)
    arbiter.to(9 * S)
    assert arbiter.written == [(3 * S, BOTTOM, False)]


def test_a_lease_that_ends_is_a_death():
    arbiter = gripped(UNWIND)
    arbiter.rules.renew(arbiter.grip, 2 * S)
    arbiter.rules.renew(arbiter.changer, 2 * S + 1)
    assert arbiter.rules.deadline == 3 * S
    assert arbiter.rules.expire(3 * S - 1) == []
    assert arbiter.rules.expire(3 * S) == [arbiter.grip]
    assert arbiter.rules.levels[TOP] is False
    assert arbiter.rules.expire(3 * S) == []


def test_a_write_renews_the_lease():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    assert arbiter.grip.lease_until == arbiter.now + S


def test_a_failing_will_goes_on():
    arbiter = gripped(UNWIND)
    arbiter.lines.error = OSError(5, "Input/output error")
    arbiter.die(arbiter.grip)
    arbiter.lines.error = None
    arbiter.to(10 * S)
    assert [line for _, line, _ in arbiter.written] == [CYLINDER, BOTTOM]


# Clients


def test_a_line_has_one_writer():
    arbiter = Arbiter()
    with pytest.raises(LineBusyError, match=r"bottom belongs to grip \(pid 7\)"):
        arbiter.hello("other", (BOTTOM,))
    with pytest.raises(LineBusyError, match="name belongs to grip"):
        arbiter.hello("grip", (BOTTOM,)[:0])


def test_unknown_and_foreign_lines():
    arbiter = Arbiter()
    with pytest.raises(UsageError, match=r"no line botom \(did you mean bottom\?\)"):
        arbiter.hello("x", ("botom",))
    with pytest.raises(UsageError, match="grip does not write unlock"):
        arbiter.set(arbiter.grip, unlock=True)
    with pytest.raises(UsageError, match="grip does not write unlock"):
        arbiter.set(arbiter.grip, (LastWillStep(UNLOCK),), bottom=True)
    with pytest.raises(UsageError, match="grip does not write unlock"):
        arbiter.rules.bye(arbiter.grip, (LastWillStep(UNLOCK),), arbiter.now)
    assert arbiter.written == []


def test_a_failing_write_is_told():
    arbiter = Arbiter()
    arbiter.lines.error = OSError(5, "Input/output error")
    with pytest.raises(WireError, match="Input/output error"):
        arbiter.set(arbiter.grip, bottom=True)
    assert arbiter.rules.levels[BOTTOM] is False


@pytest.mark.parametrize(
    "fields", [{"exclusions": [("a", "x")]}, {"max_active_us": {"x": 1}}, {"lines": ("a", "a")}]
)
def test_a_wrong_policy(fields):
    with pytest.raises(UsageError, match="policy"):
        Policy(**{"lines": ("a", "b")} | fields)


# Whatever the clients do

moves = st.tuples(
    st.sampled_from([0, 1, 20 * MS, 50 * MS, 400 * MS, 3 * S]),
    st.sampled_from(["grip", "changer", "grip dies", "changer dies", "grip leaves"]),
    st.dictionaries(st.sampled_from(GRIP), st.booleans(), min_size=1),
    st.booleans(),
)


@given(st.lists(moves, max_size=40))
def test_the_interlocks_hold_whatever_the_clients_do(todo):
    arbiter = Arbiter()
    for wait, who, levels, unlock in todo:
        arbiter.to(arbiter.now + wait)
        try:
            if who == "grip":
                arbiter.set(arbiter.grip, UNWIND, **levels)
            elif who == "changer":
                arbiter.set(arbiter.changer, (), unlock=unlock)
            elif who == "grip dies" and arbiter.grip in arbiter.alive:
                arbiter.die(arbiter.grip)
                arbiter.grip = arbiter.hello("grip", GRIP)
            elif who == "grip leaves" and arbiter.grip in arbiter.alive:
                arbiter.rules.bye(arbiter.grip, (), arbiter.now)
                arbiter.alive.remove(arbiter.grip)
                arbiter.grip = arbiter.hello("grip", GRIP)
            elif who == "changer dies" and arbiter.changer in arbiter.alive:
                arbiter.die(arbiter.changer)
                arbiter.changer = arbiter.hello("changer", (UNLOCK,))
        except LastWillRunsError as error:
            arbiter.to(arbiter.now + error.retry_us)
            name = who.split()[0]
            setattr(arbiter, name, arbiter.hello(name, GRIP if name == "grip" else (UNLOCK,)))
        except LineRefusedError:
            pass
    arbiter.to(arbiter.now + 20 * S)
    assert arbiter.lines.state == arbiter.rules.levels
    state, since = dict.fromkeys(LINES, False), {}
    for at, line, level in [*arbiter.written, (arbiter.now, None, None)]:
        assert not state[UNLOCK] or at - since[UNLOCK] <= 3 * S
        if line:
            assert state[line] != level
            assert at - since.get(line, 0) >= 50 * MS
            state[line], since[line] = level, at
            assert not (state[UNLOCK] and any(state[other] for other in GRIP))
    assert all(not session.queue for session in arbiter.rules.sessions)


# IL-01, IL-05 by what the sensors say


def sensing(**told):
    arbiter = Arbiter(SENSING)
    arbiter.rules.predicates.update(
        {"free": True, "locked": True, "closed": True} | told, arbiter.now, arbiter.now
    )
    return arbiter


def refusal(arbiter, session=None, line=BOTTOM):
    session = session or arbiter.grip
    before, will = dict(arbiter.rules.levels), session.will
    with pytest.raises(LineRefusedError) as caught:
        arbiter.set(session, (LastWillStep(line),), **{line: True})
    assert (arbiter.rules.levels, session.will) == (before, will), "nothing has changed"
    return str(caught.value)


def test_a_line_is_activated_when_the_sensors_say_so():
    arbiter = sensing()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.set(arbiter.changer, unlock=True)
    assert [line for _, line, _ in arbiter.written] == [BOTTOM, UNLOCK]


def test_before_anybody_said_anything_every_activation_is_refused():
    arbiter = Arbiter(SENSING)
    assert refusal(arbiter) == (
        "IL-13: bottom is not activated: no process that reads the sensors has reported yet "
        "whether the e-stop is closed."
    )


def test_a_predicate_that_does_not_hold_refuses():
    arbiter = sensing(locked=False)
    assert refusal(arbiter) == "IL-05: bottom is not activated: the tool is not proven to be locked."
    arbiter.set(arbiter.changer, unlock=True)
    arbiter = sensing(free=False)
    assert refusal(arbiter, arbiter.changer, UNLOCK) == (
        "IL-01: unlock is not activated: the sensors do not prove that nothing is gripped."
    )
    arbiter.set(arbiter.grip, bottom=True)


def test_a_predicate_expires_150_ms_after_the_sensors_proved_it_not_after_it_came():
    arbiter = sensing()
    arbiter.to(arbiter.now + 149_999)
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(arbiter.now + 1)
    arbiter.rules.predicates.update({"closed": True}, arbiter.now, arbiter.now)
    assert refusal(arbiter, line=TOP) == (
        "IL-05: top is not activated: for 0.15 s no process that reads the sensors has reported "
        "whether the tool is locked."
    )
    # what waited in a socket while the arbiter was stopped is as old as it is
    arbiter.rules.predicates.update({"locked": True}, arbiter.now - 150 * MS, arbiter.now)
    assert "for 0.15 s" in refusal(arbiter, line=TOP)


def test_what_is_said_of_a_time_ahead_of_now_counts_for_nothing():
    arbiter = sensing()
    arbiter.to(arbiter.now + 150 * MS)
    with pytest.raises(UsageError, match="at_us is 1 µs ahead of now"):
        arbiter.rules.predicates.update({"locked": True, "closed": True}, arbiter.now + 1, arbiter.now)
    assert "for 0.15 s" in refusal(arbiter, line=TOP)


def test_predicates_are_known_beforehand():
    arbiter = sensing()
    with pytest.raises(
        UsageError, match=r"no predicate lockd \(did you mean locked\?\); it has closed, free, locked"
    ):
        arbiter.rules.predicates.update({"closed": True, "lockd": True}, arbiter.now, arbiter.now)
    assert arbiter.rules.predicates.proofs.keys() == {"closed", "free", "locked"}


def test_faults_of_clients_are_known_beforehand_and_take_no_room_of_an_interlock():
    arbiter = Arbiter(replace(SENSING, faults=("sensor_fault",)))
    sensed = arbiter.rules.predicates
    for number in range(100):
        with pytest.raises(UsageError, match=f"no fault fault{number}; it has sensor_fault"):
            sensed.latch_for_client(f"fault{number}", "why")
    sensed.latch_for_client("sensor_fault", "IL-04: both bits are set.")
    sensed.latch_for_client("sensor_fault", "another reason")
    with pytest.raises(UsageError, match="no fault closed"):
        sensed.latch_for_client("closed", "a client refuses nothing")
    sensed.update({"closed": False}, arbiter.now, arbiter.now)
    assert sensed.faults == {
        "sensor_fault": "IL-04: both bits are set.",
        "closed": "IL-13: the e-stop was opened.",
    }


def test_an_e_stop_latches_whatever_an_older_journal_is_full_of():
    """Once 32 faults of clients filled the table, and an open e-stop latched nothing."""
    full = ArbiterState({f"fault{number}": "why" for number in range(32)})
    rules = LineArbiter(Lines(), SENSING, 0, full)
    rules.predicates.update({"closed": False}, 0, 0)
    assert rules.state.faults["closed"] == "IL-13: the e-stop was opened."
    rules = LineArbiter(Lines(unlock=True), POLICY, 0, full)
    rules.advance(3 * S)
    assert "IL-03 unlock" in rules.state.faults


def test_a_will_locks_its_lines_no_longer_than_the_tool_needs():
    arbiter = Arbiter(replace(POLICY, longest_last_will_us=6 * S))
    arbiter.set(arbiter.grip, (LastWillStep(BOTTOM), LastWillStep(TOP, after_us=6 * S)), bottom=True)
    late = (LastWillStep(BOTTOM), LastWillStep(TOP, after_us=6 * S + 1))
    for leave in (
        lambda: arbiter.set(arbiter.grip, late),
        lambda: arbiter.rules.bye(arbiter.grip, late, arbiter.now),
    ):
        with pytest.raises(
            UsageError, match="deactivates top 6000001 µs after the death; the longest last will"
        ):
            leave()
    arbiter.rules.bye(arbiter.changer, (), arbiter.now)
    with pytest.raises(UsageError, match="the longest last will"):
        arbiter.hello("other", (UNLOCK,), (LastWillStep(UNLOCK, after_us=9 * S),))
    assert arbiter.grip.will[-1].after_us == 6 * S
    assert arbiter.hello("changer", (UNLOCK,)), "who was refused has not come"


def test_what_was_said_earlier_and_comes_later_counts_for_nothing():
    arbiter = sensing()
    arbiter.rules.predicates.update({"locked": False}, arbiter.now - 1, arbiter.now)
    arbiter.set(arbiter.grip, bottom=True)


@pytest.mark.parametrize("change", ["expired", "locked", "free", "closed"])
def test_nothing_is_deactivated_and_no_deactivation_refused_for_want_of_a_predicate(change):
    arbiter = sensing()
    arbiter.set(arbiter.grip, (LastWillStep(BOTTOM),), bottom=True, top=True)
    if change != "expired":
        arbiter.rules.predicates.update({change: False}, arbiter.now, arbiter.now)
    arbiter.to(arbiter.now + 10 * S)
    assert arbiter.rules.levels[BOTTOM]
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.set(arbiter.grip, top=False)
    assert arbiter.rules.levels == {UNLOCK: False, BOTTOM: True, CYLINDER: False, TOP: False}
    arbiter.die(arbiter.grip)
    assert not arbiter.rules.levels[BOTTOM]


# IL-13


def test_il_13_an_open_e_stop_latches_until_a_reset_while_it_is_closed():
    arbiter = sensing()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.rules.predicates.update({"closed": False}, arbiter.now, arbiter.now)
    assert arbiter.rules.levels[BOTTOM], "what is held stays held"
    assert refusal(arbiter, line=TOP) == "IL-13: top is not activated: the e-stop is open."
    with pytest.raises(LineRefusedError, match=r"^IL-13: the e-stop is open: this fault stays"):
        arbiter.rules.reset(arbiter.now)
    arbiter.rules.predicates.update({"closed": True}, arbiter.now, arbiter.now)
    assert refusal(arbiter, line=TOP) == (
        "IL-13: top is not activated: the e-stop was opened; reset the faults first."
    )
    assert arbiter.rules.predicates.faults == {"closed": "IL-13: the e-stop was opened."}
    arbiter.rules.reset(arbiter.now)
    assert arbiter.rules.predicates.faults == {}
    arbiter.set(arbiter.grip, top=True)


def test_il_13_a_reset_needs_to_know_that_the_e_stop_is_closed():
    arbiter = sensing(closed=False)
    arbiter.rules.predicates.update({"closed": True}, arbiter.now, arbiter.now)
    arbiter.to(arbiter.now + 150 * MS)
    with pytest.raises(
        LineRefusedError, match="no process that reads the sensors has reported whether the e-stop"
    ):
        arbiter.rules.reset(arbiter.now)
    assert "closed" in arbiter.rules.predicates.faults


def test_a_reset_clears_every_fault_that_is_over():
    arbiter = sensing(closed=False)
    arbiter.rules.predicates.latch("sensor_fault", "IL-04: both bits are set.")
    arbiter.rules.predicates.latch("sensor_fault", "another reason")
    assert arbiter.rules.predicates.faults["sensor_fault"] == "IL-04: both bits are set."
    with pytest.raises(LineRefusedError):
        arbiter.rules.reset(arbiter.now)
    assert list(arbiter.rules.predicates.faults) == ["closed"]


def test_an_expired_e_stop_refuses_and_is_no_fault():
    arbiter = sensing()
    arbiter.to(arbiter.now + 1 * S)
    assert "for 1 s no process" in refusal(arbiter)
    assert arbiter.rules.predicates.faults == {}


# IL-08


def test_il_08_at_least_50_ms_lie_between_the_two_lines():
    blowing = Policy(LINES, [Exclusion(BOTTOM, TOP, "IL-08", "IL-08", 50 * MS)], min_switch_us=0)
    arbiter = Arbiter(blowing)
    arbiter.set(arbiter.grip, bottom=True)
    assert refusal(arbiter, line=TOP) == "IL-08: top is not activated while bottom is active."
    arbiter.set(arbiter.grip, bottom=False)
    assert refusal(arbiter, line=TOP) == "IL-08: top is not activated within 50 ms after bottom."
    arbiter.to(arbiter.now + 50 * MS - 1)
    refusal(arbiter, line=TOP)
    arbiter.to(arbiter.now + 1)
    arbiter.set(arbiter.grip, top=True)
    arbiter.set(arbiter.grip, top=False)
    assert "IL-08: bottom is not activated within 50 ms after top." in refusal(arbiter)
