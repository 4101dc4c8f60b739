"""The rules of the line owner, in virtual time."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.arbiter import Exclusion, LineArbiter, Policy
from end_effector_hal.arbiter.rules._session import LastWillRunsError
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


class Owner:
    """A keeper in virtual time, with two clients; between the steps it does what is due, when it is due."""

    def __init__(self, policy=POLICY, start=1 * S, **active):
        self.lines = Lines(**active)
        self.keeper = LineArbiter(self.lines, policy, 0)
        self.now = 0
        self.alive = []
        self.to(start)
        self.lines.written.clear()
        self.grip = self.hello("grip", GRIP)
        self.changer = self.hello("changer", (UNLOCK,))

    def hello(self, client, lines, will=()):
        session = self.keeper.hello(client, TOKEN, lines, will, self.now, pid=7)
        self.alive.append(session)
        return session

    def to(self, at):
        """Time passes; the living renew their leases."""
        while True:
            for session in self.alive:
                self.keeper.renew(session, self.now)
            step = min(at, max(self.keeper.deadline or at, self.now))
            step = min(step, self.now + 500 * MS)
            self.now = self.lines.now = step
            self.keeper.advance(step)
            if step >= at:
                return

    def set(self, session, will=None, **levels):
        return self.keeper.write(session, levels, will, self.now)

    def die(self, session):
        self.alive.remove(session)
        self.keeper.dead(session, "killed", self.now)

    @property
    def written(self):
        return self.lines.written


def test_a_write_is_applied_at_once_and_as_a_whole():
    owner = Owner()
    assert owner.set(owner.grip, bottom=True, top=True) == 0
    assert owner.written == [(1 * S, BOTTOM, True), (1 * S, TOP, True)]
    assert owner.keeper.levels == {UNLOCK: False, BOTTOM: True, CYLINDER: False, TOP: True}


def test_writing_the_same_again_writes_nothing():
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    assert owner.set(owner.grip, bottom=True) == 0
    assert len(owner.written) == 1


# IL-10


def test_il_10_a_second_change_waits_until_50_ms_are_over():
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    owner.to(1 * S + 10 * MS)
    assert owner.set(owner.grip, bottom=False) == 40 * MS
    assert owner.keeper.deadline == 1 * S + 50 * MS
    owner.to(1 * S + 49 * MS)
    assert owner.keeper.levels[BOTTOM]
    owner.to(2 * S)
    assert owner.written[1:] == [(1 * S + 50 * MS, BOTTOM, False)]


def test_il_10_what_comes_after_waits_behind_it():
    owner = Owner()
    owner.set(owner.grip, top=True, bottom=True)
    assert owner.set(owner.grip, top=False) == 50 * MS
    assert owner.set(owner.grip, cylinder=True) == 50 * MS
    assert owner.set(owner.grip, top=True) == 100 * MS
    assert owner.set(owner.changer, unlock=False) == 0
    owner.to(2 * S)
    assert owner.written[2:] == [
        (1 * S + 50 * MS, TOP, False),
        (1 * S + 50 * MS, CYLINDER, True),
        (1 * S + 100 * MS, TOP, True),
    ]


@pytest.mark.parametrize("end", ["write", "bye", "dead"])
def test_an_activation_that_waits_and_was_given_up_is_forgotten(end):
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    owner.to(1 * S + 60 * MS)
    owner.set(owner.grip, bottom=False)
    owner.to(1 * S + 70 * MS)
    assert owner.set(owner.grip, bottom=True, top=True) == 40 * MS
    if end == "write":
        owner.set(owner.grip, bottom=False)
    elif end == "bye":
        owner.alive.remove(owner.grip)
        owner.keeper.bye(owner.grip, (), owner.now)
    else:
        owner.die(owner.grip)
    owner.to(2 * S)
    assert owner.written[2:] == ([(1 * S + 70 * MS, TOP, True)] if end == "write" else [])


def test_il_10_holds_for_the_first_write_after_the_start():
    owner = Owner(start=20 * MS)
    assert owner.set(owner.grip, bottom=True) == 30 * MS
    assert owner.set(owner.grip, bottom=True) == 30 * MS


def test_il_10_bounded():
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    for _ in range(64):
        owner.set(owner.grip, bottom=False)
    with pytest.raises(LineRefusedError, match="IL-10: 64 writes wait"):
        owner.set(owner.grip, bottom=False)


# IL-01, IL-05


@pytest.mark.parametrize("line", GRIP)
def test_il_01_no_unlock_while_a_gripping_line_is_active(line):
    owner = Owner()
    owner.set(owner.grip, **{line: True})
    with pytest.raises(LineRefusedError, match=rf"IL-01: unlock \(tool changer\) .* while {line} is active"):
        owner.set(owner.changer, unlock=True)
    owner.to(2 * S)
    owner.set(owner.grip, **{line: False})
    assert owner.set(owner.changer, unlock=True) == 0


@pytest.mark.parametrize("line", GRIP)
def test_il_05_no_gripping_while_unlocked(line):
    owner = Owner()
    owner.set(owner.changer, unlock=True)
    with pytest.raises(LineRefusedError, match="IL-05"):
        owner.set(owner.grip, **{line: True})
    assert owner.written == [(1 * S, UNLOCK, True)]


def test_ids_of_an_exclusion_can_be_named():
    policy = Policy(LINES, [Exclusion(BOTTOM, TOP, "IL-08", "IL-08")])
    owner = Owner(policy)
    with pytest.raises(LineRefusedError, match="IL-08"):
        owner.set(owner.grip, bottom=True, top=True)
    assert owner.written == []


def test_a_swap_in_one_write_is_no_violation():
    owner = Owner(Policy(LINES, [(BOTTOM, TOP)]))
    owner.set(owner.grip, bottom=True)
    assert owner.set(owner.grip, bottom=False, top=True) == 50 * MS
    owner.to(2 * S)
    assert owner.keeper.levels == {UNLOCK: False, BOTTOM: False, CYLINDER: False, TOP: True}


def test_a_waiting_activation_excludes_already():
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    owner.set(owner.grip, bottom=False)
    owner.set(owner.grip, bottom=True)
    with pytest.raises(LineRefusedError):
        owner.set(owner.changer, unlock=True)


def test_an_activation_that_waits_while_the_line_is_inactive_excludes():
    owner = Owner()
    for level in (True, False, True):
        owner.set(owner.grip, bottom=level)
    owner.to(1 * S + 60 * MS)
    assert owner.keeper.levels[BOTTOM] is False
    with pytest.raises(LineRefusedError, match="IL-01"):
        owner.set(owner.changer, unlock=True)


def test_an_adopted_violation_is_not_repeated():
    owner = Owner(unlock=True, bottom=True, policy=Policy(LINES, POLICY.exclusions))
    owner.set(owner.grip, cylinder=False, bottom=False)
    owner.set(owner.grip, top=False, bottom=False)
    with pytest.raises(LineRefusedError, match="IL-05"):
        owner.set(owner.grip, bottom=True)


def test_a_line_that_is_to_be_inactive_is_activated_only_by_the_rules():
    owner = Owner(unlock=True, bottom=True, start=20 * MS, policy=Policy(LINES, POLICY.exclusions))
    assert owner.set(owner.grip, bottom=False) == 30 * MS
    with pytest.raises(LineRefusedError, match="IL-05"):
        owner.set(owner.grip, bottom=True)


def test_a_waiting_deactivation_does_not_free_yet():
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    owner.set(owner.grip, bottom=False)
    with pytest.raises(LineRefusedError):
        owner.set(owner.changer, unlock=True)
    owner.to(1 * S + 50 * MS)
    assert owner.set(owner.changer, unlock=True) == 0


def test_an_adopted_violation_is_logged_and_can_be_written_as_it_is(caplog):
    owner = Owner(unlock=True, bottom=True, policy=Policy(LINES, POLICY.exclusions))
    assert "found active together" in caplog.text
    assert owner.set(owner.grip, bottom=True) == 0


# IL-03


def test_il_03_ends_an_activation_after_3_s():
    owner = Owner()
    owner.set(owner.changer, unlock=True)
    owner.to(3 * S)
    owner.set(owner.changer, unlock=True)
    owner.to(10 * S)
    assert owner.written == [(1 * S, UNLOCK, True), (4 * S, UNLOCK, False)]
    assert list(owner.keeper.trips) == [(4 * S, UNLOCK)]


def test_il_03_counts_from_the_adoption():
    owner = Owner(unlock=True)
    owner.to(5 * S)
    assert owner.written == [(3 * S, UNLOCK, False)]


def test_il_03_that_fails_is_tried_again():
    owner = Owner()
    owner.set(owner.changer, unlock=True)
    owner.lines.error = OSError(5, "Input/output error")
    owner.to(5 * S)
    owner.lines.error = None
    owner.to(9 * S)
    assert owner.written == [(1 * S, UNLOCK, True), (7 * S, UNLOCK, False)]


# Wills

UNWIND = (
    LastWillStep(TOP, False, 0),
    LastWillStep(CYLINDER, False, 2 * S),
    LastWillStep(BOTTOM, False, 4 * S),
)


def gripped(will):
    owner = Owner()
    owner.set(owner.grip, will, bottom=True, cylinder=True, top=True)
    owner.written.clear()
    owner.to(2 * S)
    return owner


def test_a_will_is_executed_in_order_and_in_time():
    owner = gripped(UNWIND)
    owner.die(owner.grip)
    owner.to(10 * S)
    assert owner.written == [(2 * S, TOP, False), (4 * S, CYLINDER, False), (6 * S, BOTTOM, False)]


def test_an_empty_will_holds():
    owner = gripped(())
    owner.die(owner.grip)
    owner.to(10 * S)
    assert owner.written == []
    assert owner.hello("grip", GRIP).client == "grip"


def test_the_last_will_counts_and_stays_until_the_next():
    owner = gripped(UNWIND)
    owner.set(owner.grip, ())
    owner.set(owner.grip, bottom=True)
    owner.die(owner.grip)
    owner.to(10 * S)
    assert owner.written == []


def test_a_refused_write_leaves_the_will_as_it_was():
    owner = gripped(UNWIND)
    with pytest.raises(LineRefusedError):
        owner.keeper.write(owner.changer, {UNLOCK: True}, (LastWillStep(UNLOCK),), owner.now)
    assert owner.changer.will == ()


def test_who_was_taken_for_dead_is_told_once():
    owner = Owner()
    assert not owner.grip.declared_dead
    owner.die(owner.grip)
    back = owner.hello("grip", GRIP)
    assert back.declared_dead
    owner.alive.remove(back)
    owner.keeper.bye(back, (), owner.now)
    assert not owner.hello("grip", GRIP).declared_dead, "it left in order"


def test_the_will_of_a_hello_counts():
    owner = Owner(bottom=True)
    owner.die(owner.grip)
    owner.die(owner.hello("grip", GRIP, (LastWillStep(BOTTOM),)))
    assert owner.written == [(1 * S, BOTTOM, False)]


def test_a_will_keeps_il_10():
    owner = Owner()
    owner.set(owner.grip, (LastWillStep(TOP), LastWillStep(BOTTOM)), top=True)
    owner.die(owner.grip)
    owner.to(2 * S)
    assert owner.written == [(1 * S, TOP, True), (1 * S + 50 * MS, TOP, False)]


def test_a_death_cancels_waiting_activations_and_keeps_deactivations():
    owner = Owner()
    owner.set(owner.grip, bottom=True, top=True)
    owner.set(owner.grip, bottom=False, cylinder=True)
    owner.set(owner.grip, (LastWillStep(CYLINDER),), bottom=True)
    owner.die(owner.grip)
    owner.to(3 * S)
    assert owner.written[2:] == [(1 * S + 50 * MS, BOTTOM, False)]


def test_hello_waits_for_the_end_of_a_will():
    owner = gripped(UNWIND)
    owner.die(owner.grip)
    owner.to(3 * S)
    for client, lines in (("grip", GRIP), ("other", (BOTTOM,))):
        with pytest.raises(LastWillRunsError, match="grip is being executed") as caught:
            owner.hello(client, lines)
        assert caught.value.retry_us == 3 * S
    owner.to(6 * S)
    assert owner.hello("grip", GRIP).client == "grip"


def test_no_unlock_while_a_will_is_not_over():
    owner = gripped(UNWIND)
    owner.die(owner.grip)
    owner.to(5 * S)
    with pytest.raises(LineRefusedError, match="IL-01"):
        owner.set(owner.changer, unlock=True)
    owner.to(6 * S)
    assert owner.set(owner.changer, unlock=True) == 0


def test_bye_executes_what_it_says_and_nothing_else():
    owner = gripped(UNWIND)
    owner.keeper.bye(owner.grip, (LastWillStep(BOTTOM, False, 1 * S),), owner.now)
    owner.alive.remove(owner.grip)
    owner.to(9 * S)
    assert owner.written == [(3 * S, BOTTOM, False)]


def test_a_lease_that_ends_is_a_death():
    owner = gripped(UNWIND)
    owner.keeper.renew(owner.grip, 2 * S)
    owner.keeper.renew(owner.changer, 2 * S + 1)
    assert owner.keeper.deadline == 3 * S
    assert owner.keeper.expire(3 * S - 1) == []
    assert owner.keeper.expire(3 * S) == [owner.grip]
    assert owner.keeper.levels[TOP] is False
    assert owner.keeper.expire(3 * S) == []


def test_a_write_renews_the_lease():
    owner = Owner()
    owner.set(owner.grip, bottom=True)
    assert owner.grip.lease_until == owner.now + S


def test_a_failing_will_goes_on():
    owner = gripped(UNWIND)
    owner.lines.error = OSError(5, "Input/output error")
    owner.die(owner.grip)
    owner.lines.error = None
    owner.to(10 * S)
    assert [line for _, line, _ in owner.written] == [CYLINDER, BOTTOM]


# Clients


def test_a_line_has_one_writer():
    owner = Owner()
    with pytest.raises(LineBusyError, match=r"bottom belongs to grip \(pid 7\)"):
        owner.hello("other", (BOTTOM,))
    with pytest.raises(LineBusyError, match="name belongs to grip"):
        owner.hello("grip", (BOTTOM,)[:0])


def test_unknown_and_foreign_lines():
    owner = Owner()
    with pytest.raises(UsageError, match=r"no line botom \(did you mean bottom\?\)"):
        owner.hello("x", ("botom",))
    with pytest.raises(UsageError, match="grip does not write unlock"):
        owner.set(owner.grip, unlock=True)
    with pytest.raises(UsageError, match="grip does not write unlock"):
        owner.set(owner.grip, (LastWillStep(UNLOCK),), bottom=True)
    with pytest.raises(UsageError, match="grip does not write unlock"):
        owner.keeper.bye(owner.grip, (LastWillStep(UNLOCK),), owner.now)
    assert owner.written == []


def test_a_failing_write_is_told():
    owner = Owner()
    owner.lines.error = OSError(5, "Input/output error")
    with pytest.raises(WireError, match="Input/output error"):
        owner.set(owner.grip, bottom=True)
    assert owner.keeper.levels[BOTTOM] is False


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
    owner = Owner()
    for wait, who, levels, unlock in todo:
        owner.to(owner.now + wait)
        try:
            if who == "grip":
                owner.set(owner.grip, UNWIND, **levels)
            elif who == "changer":
                owner.set(owner.changer, (), unlock=unlock)
            elif who == "grip dies" and owner.grip in owner.alive:
                owner.die(owner.grip)
                owner.grip = owner.hello("grip", GRIP)
            elif who == "grip leaves" and owner.grip in owner.alive:
                owner.keeper.bye(owner.grip, (), owner.now)
                owner.alive.remove(owner.grip)
                owner.grip = owner.hello("grip", GRIP)
            elif who == "changer dies" and owner.changer in owner.alive:
                owner.die(owner.changer)
                owner.changer = owner.hello("changer", (UNLOCK,))
        except LastWillRunsError as error:
            owner.to(owner.now + error.retry_us)
            name = who.split()[0]
            setattr(owner, name, owner.hello(name, GRIP if name == "grip" else (UNLOCK,)))
        except LineRefusedError:
            pass
    owner.to(owner.now + 20 * S)
    assert owner.lines.state == owner.keeper.levels
    state, since = dict.fromkeys(LINES, False), {}
    for at, line, level in [*owner.written, (owner.now, None, None)]:
        assert not state[UNLOCK] or at - since[UNLOCK] <= 3 * S
        if line:
            assert state[line] != level
            assert at - since.get(line, 0) >= 50 * MS
            state[line], since[line] = level, at
            assert not (state[UNLOCK] and any(state[other] for other in GRIP))
    assert all(not session.queue for session in owner.keeper.sessions)


# IL-01, IL-05 by what the sensors say


def sensing(**told):
    owner = Owner(SENSING)
    owner.keeper.sensed.tell({"free": True, "locked": True, "closed": True} | told, owner.now, owner.now)
    return owner


def refusal(owner, session=None, line=BOTTOM):
    session = session or owner.grip
    before, will = dict(owner.keeper.levels), session.will
    with pytest.raises(LineRefusedError) as caught:
        owner.set(session, (LastWillStep(line),), **{line: True})
    assert (owner.keeper.levels, session.will) == (before, will), "nothing has changed"
    return str(caught.value)


def test_a_line_is_activated_when_the_sensors_say_so():
    owner = sensing()
    owner.set(owner.grip, bottom=True)
    owner.set(owner.changer, unlock=True)
    assert [line for _, line, _ in owner.written] == [BOTTOM, UNLOCK]


def test_before_anybody_said_anything_every_activation_is_refused():
    owner = Owner(SENSING)
    assert refusal(owner) == (
        "IL-13: bottom is not activated: nobody who reads the sensors has said yet whether the e-stop is closed."
    )


def test_a_predicate_that_does_not_hold_refuses():
    owner = sensing(locked=False)
    assert refusal(owner) == "IL-05: bottom is not activated: the tool is not proven to be locked."
    owner.set(owner.changer, unlock=True)
    owner = sensing(free=False)
    assert refusal(owner, owner.changer, UNLOCK) == (
        "IL-01: unlock is not activated: the sensors do not prove that nothing is gripped."
    )
    owner.set(owner.grip, bottom=True)


def test_a_predicate_expires_150_ms_after_the_sensors_proved_it_not_after_it_came():
    owner = sensing()
    owner.to(owner.now + 149_999)
    owner.set(owner.grip, bottom=True)
    owner.to(owner.now + 1)
    owner.keeper.sensed.tell({"closed": True}, owner.now, owner.now)
    assert refusal(owner, line=TOP) == (
        "IL-05: top is not activated: for 0.15 s nobody who reads the sensors has said whether the tool is locked."
    )
    # what waited in a socket while the owner was stopped is as old as it is
    owner.keeper.sensed.tell({"locked": True}, owner.now - 150 * MS, owner.now)
    assert "for 0.15 s" in refusal(owner, line=TOP)


def test_what_is_said_of_a_time_ahead_of_now_counts_for_nothing():
    owner = sensing()
    owner.to(owner.now + 150 * MS)
    with pytest.raises(UsageError, match="at_us is 1 µs ahead of now"):
        owner.keeper.sensed.tell({"locked": True, "closed": True}, owner.now + 1, owner.now)
    assert "for 0.15 s" in refusal(owner, line=TOP)


def test_predicates_are_known_beforehand():
    owner = sensing()
    with pytest.raises(
        UsageError, match=r"no predicate lockd \(did you mean locked\?\); it knows closed, free, locked"
    ):
        owner.keeper.sensed.tell({"closed": True, "lockd": True}, owner.now, owner.now)
    assert owner.keeper.sensed.claims.keys() == {"closed", "free", "locked"}


def test_faults_of_clients_are_known_beforehand_and_take_no_room_of_an_interlock():
    owner = Owner(replace(SENSING, faults=("sensor_fault",)))
    sensed = owner.keeper.sensed
    for number in range(100):
        with pytest.raises(UsageError, match=f"no fault fault{number}; it knows sensor_fault"):
            sensed.keep(f"fault{number}", "why")
    sensed.keep("sensor_fault", "IL-04: both bits are set.")
    sensed.keep("sensor_fault", "another reason")
    with pytest.raises(UsageError, match="no fault closed"):
        sensed.keep("closed", "a client refuses nothing")
    sensed.tell({"closed": False}, owner.now, owner.now)
    assert sensed.faults == {
        "sensor_fault": "IL-04: both bits are set.",
        "closed": "IL-13: the e-stop was opened.",
    }


def test_an_e_stop_latches_whatever_an_older_journal_is_full_of():
    """Once 32 faults of clients filled the table, and an open e-stop latched nothing."""
    full = ArbiterState({f"fault{number}": "why" for number in range(32)})
    keeper = LineArbiter(Lines(), SENSING, 0, full)
    keeper.sensed.tell({"closed": False}, 0, 0)
    assert keeper.memory.faults["closed"] == "IL-13: the e-stop was opened."
    keeper = LineArbiter(Lines(unlock=True), POLICY, 0, full)
    keeper.advance(3 * S)
    assert "IL-03 unlock" in keeper.memory.faults


def test_a_will_locks_its_lines_no_longer_than_the_tool_needs():
    owner = Owner(replace(POLICY, longest_will_us=6 * S))
    owner.set(owner.grip, (LastWillStep(BOTTOM), LastWillStep(TOP, after_us=6 * S)), bottom=True)
    late = (LastWillStep(BOTTOM), LastWillStep(TOP, after_us=6 * S + 1))
    for leave in (lambda: owner.set(owner.grip, late), lambda: owner.keeper.bye(owner.grip, late, owner.now)):
        with pytest.raises(UsageError, match="deactivates top 6000001 µs after the death; the longest will"):
            leave()
    owner.keeper.bye(owner.changer, (), owner.now)
    with pytest.raises(UsageError, match="the longest will"):
        owner.hello("other", (UNLOCK,), (LastWillStep(UNLOCK, after_us=9 * S),))
    assert owner.grip.will[-1].after_us == 6 * S
    assert owner.hello("changer", (UNLOCK,)), "who was refused has not come"


def test_what_was_said_earlier_and_comes_later_counts_for_nothing():
    owner = sensing()
    owner.keeper.sensed.tell({"locked": False}, owner.now - 1, owner.now)
    owner.set(owner.grip, bottom=True)


@pytest.mark.parametrize("change", ["expired", "locked", "free", "closed"])
def test_nothing_is_deactivated_and_no_deactivation_refused_for_want_of_a_predicate(change):
    owner = sensing()
    owner.set(owner.grip, (LastWillStep(BOTTOM),), bottom=True, top=True)
    if change != "expired":
        owner.keeper.sensed.tell({change: False}, owner.now, owner.now)
    owner.to(owner.now + 10 * S)
    assert owner.keeper.levels[BOTTOM]
    owner.set(owner.grip, bottom=True)
    owner.set(owner.grip, top=False)
    assert owner.keeper.levels == {UNLOCK: False, BOTTOM: True, CYLINDER: False, TOP: False}
    owner.die(owner.grip)
    assert not owner.keeper.levels[BOTTOM]


# IL-13


def test_il_13_an_open_e_stop_latches_until_a_reset_while_it_is_closed():
    owner = sensing()
    owner.set(owner.grip, bottom=True)
    owner.keeper.sensed.tell({"closed": False}, owner.now, owner.now)
    assert owner.keeper.levels[BOTTOM], "what is held stays held"
    assert refusal(owner, line=TOP) == "IL-13: top is not activated: the e-stop is open."
    with pytest.raises(LineRefusedError, match=r"^IL-13: the e-stop is open: this fault stays"):
        owner.keeper.reset(owner.now)
    owner.keeper.sensed.tell({"closed": True}, owner.now, owner.now)
    assert refusal(owner, line=TOP) == (
        "IL-13: top is not activated: the e-stop was opened; reset the faults first."
    )
    assert owner.keeper.sensed.faults == {"closed": "IL-13: the e-stop was opened."}
    owner.keeper.reset(owner.now)
    assert owner.keeper.sensed.faults == {}
    owner.set(owner.grip, top=True)


def test_il_13_a_reset_needs_to_know_that_the_e_stop_is_closed():
    owner = sensing(closed=False)
    owner.keeper.sensed.tell({"closed": True}, owner.now, owner.now)
    owner.to(owner.now + 150 * MS)
    with pytest.raises(LineRefusedError, match="nobody who reads the sensors has said whether the e-stop"):
        owner.keeper.reset(owner.now)
    assert "closed" in owner.keeper.sensed.faults


def test_a_reset_clears_every_fault_that_is_over():
    owner = sensing(closed=False)
    owner.keeper.sensed.latch("sensor_fault", "IL-04: both bits are set.")
    owner.keeper.sensed.latch("sensor_fault", "another reason")
    assert owner.keeper.sensed.faults["sensor_fault"] == "IL-04: both bits are set."
    with pytest.raises(LineRefusedError):
        owner.keeper.reset(owner.now)
    assert list(owner.keeper.sensed.faults) == ["closed"]


def test_an_expired_e_stop_refuses_and_is_no_fault():
    owner = sensing()
    owner.to(owner.now + 1 * S)
    assert "for 1 s nobody" in refusal(owner)
    assert owner.keeper.sensed.faults == {}


# IL-08


def test_il_08_at_least_50_ms_lie_between_the_two_lines():
    blowing = Policy(LINES, [Exclusion(BOTTOM, TOP, "IL-08", "IL-08", 50 * MS)], min_switch_us=0)
    owner = Owner(blowing)
    owner.set(owner.grip, bottom=True)
    assert refusal(owner, line=TOP) == "IL-08: top is not activated while bottom is active."
    owner.set(owner.grip, bottom=False)
    assert refusal(owner, line=TOP) == "IL-08: top is not activated within 50 ms after bottom."
    owner.to(owner.now + 50 * MS - 1)
    refusal(owner, line=TOP)
    owner.to(owner.now + 1)
    owner.set(owner.grip, top=True)
    owner.set(owner.grip, top=False)
    assert "IL-08: bottom is not activated within 50 ms after top." in refusal(owner)
