"""What the sensors have proven, in virtual time: IL-01, IL-05, IL-08, IL-13, faults that stay."""

from dataclasses import replace
from functools import partial

import pytest

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.rules._policy import Exclusion
from end_effector_hal.arbiter.rules._session import ArbiterState
from end_effector_hal.errors import LineRefusedError, UsageError
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
from tests.unit.arbiter.virtual_arbiter import Arbiter

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
    arbiter = Arbiter(replace(SENSING, faults={"sensor_fault": "changer"}))
    sensed, latch = arbiter.rules.predicates, partial(arbiter.rules.latch, arbiter.changer)
    for number in range(100):
        with pytest.raises(UsageError, match=f"no fault fault{number}; it has sensor_fault"):
            latch(f"fault{number}", "why")
    latch("sensor_fault", "IL-04: both bits are set.")
    latch("sensor_fault", "another reason")
    with pytest.raises(UsageError, match="no fault closed"):
        latch("closed", "a client refuses nothing")
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


def test_what_a_client_has_latched_stays_until_that_client_clears_it_or_has_gone():
    arbiter = Arbiter(replace(SENSING, faults={"sensor_fault": "changer"}))
    rules, why = arbiter.rules, "IL-04: both bits are set."
    rules.latch(arbiter.changer, "sensor_fault", why)
    assert rules.reset(arbiter.now) == {
        "sensor_fault": "changer has latched sensor_fault, and has not been reset."
    }
    rules.clear(arbiter.grip, "sensor_fault")
    assert rules.predicates.faults == {"sensor_fault": why}, "another one's"
    rules.clear(arbiter.changer, "sensor_fault")
    assert rules.predicates.faults == rules.reset(arbiter.now) == {}

    rules.latch(arbiter.changer, "sensor_fault", why)
    arbiter.die(arbiter.changer)
    assert rules.predicates.faults == {"sensor_fault": why}
    rules.reset(arbiter.now)
    assert rules.predicates.faults == {}


def test_a_client_that_connects_again_says_what_it_has_latched_by_now():
    arbiter = Arbiter(replace(SENSING, faults={"sensor_fault": "changer"}))
    rules, why = arbiter.rules, {"sensor_fault": "IL-04: both bits are set."}

    def again(faults):
        arbiter.die(arbiter.changer)
        arbiter.changer = rules.hello("changer", TOKEN, (UNLOCK,), (), arbiter.now, faults=faults)
        arbiter.alive.append(arbiter.changer)

    rules.latch(arbiter.changer, "sensor_fault", why["sensor_fault"])
    again(why)
    assert rules.reset(arbiter.now), "it is still this client's"
    arbiter.die(arbiter.changer)
    assert rules.reset(arbiter.now) == {}
    arbiter.alive.append(arbiter.changer)
    again({**why, "another": "that the policy does not list"})
    assert rules.predicates.faults == why, "a reset while it was not there"
    again({})
    assert rules.predicates.faults == why, "it has gone without clearing it, as far as is known"
    assert rules.reset(arbiter.now), "it is there again, and shows it"
    rules.clear(arbiter.changer, "sensor_fault")
    assert rules.predicates.faults == {}


def test_what_two_clients_have_latched_ends_with_the_second():
    arbiter = Arbiter(replace(SENSING, faults={"sensor_fault": "changer"}))
    for client in (arbiter.changer, arbiter.grip):
        arbiter.rules.latch(client, "sensor_fault", "why")
    arbiter.rules.clear(arbiter.grip, "sensor_fault")
    assert arbiter.rules.predicates.faults
    arbiter.rules.clear(arbiter.changer, "sensor_fault")
    assert not arbiter.rules.predicates.faults


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


# What the arbiter reads itself


def reading(**read):
    arbiter = Arbiter(replace(SENSING, proven=frozenset({"locked", "closed"})))
    arbiter.rules.predicates.update({"free": True}, arbiter.now, arbiter.now)
    arbiter.rules.predicates.read({"locked": True, "closed": True} | read, arbiter.now)
    return arbiter


def test_what_it_reads_itself_is_enough():
    arbiter = reading()
    arbiter.set(arbiter.grip, **{BOTTOM: True})


def test_what_it_reads_itself_no_message_may_name_and_none_changes():
    arbiter = reading(locked=False)
    with pytest.raises(UsageError, match="no predicate locked"):
        arbiter.rules.predicates.update({"locked": True}, arbiter.now, arbiter.now)
    assert "IL-05" in refusal(arbiter)


def test_what_others_prove_it_does_not_read():
    arbiter = reading()
    arbiter.rules.predicates.read({"free": False}, arbiter.now)
    assert arbiter.rules.predicates.proofs["free"].holds


def test_what_it_could_not_read_refuses_in_words_with_the_reason():
    arbiter = Arbiter(replace(SENSING, proven=frozenset({"locked", "closed"})))
    assert "so far the line arbiter could not read whether" in refusal(arbiter)
    arbiter = reading()
    arbiter.to(arbiter.now + 200 * MS)
    arbiter.rules.predicates.unread = "GPIO7 is held by another process."
    assert "for 0.2 s the line arbiter could not read whether" in refusal(arbiter)
    assert "(GPIO7 is held by another process)" in refusal(arbiter)


@pytest.mark.parametrize("policy", [SENSING, POLICY], ids=["with an e-stop input", "without one"])
def test_il_13_a_stop_latches_as_an_e_stop_does_and_moves_no_line(policy):
    arbiter = sensing() if policy is SENSING else Arbiter(policy)
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.rules.stop("pid 7, eehal stop")
    assert arbiter.rules.levels[BOTTOM], "what is held stays held"
    assert refusal(arbiter, line=TOP) == (
        "IL-13: top is not activated: the tool was stopped; reset the faults first."
    )
    arbiter.to(arbiter.now + 100 * MS)
    arbiter.set(arbiter.grip, bottom=False)
    assert not arbiter.rules.levels[BOTTOM], "a deactivation is never refused"
    why = "IL-13: the tool was stopped (pid 7, eehal stop): nothing is activated until a reset."
    assert arbiter.rules.state.faults == {"stop": why}
    after = LineArbiter(Lines(), policy, 0, arbiter.rules.state)
    assert "stop" in after.predicates.faults, "it stays through a restart"
    arbiter.rules.reset(arbiter.now)
    assert arbiter.rules.state.faults == {}


def test_a_clock_that_differs_is_named() -> None:
    """A program in another time namespace, or one that was restored from a snapshot."""
    rules = LineArbiter(Lines(), SENSING, 0)
    with pytest.raises(UsageError, match="3000000 µs ahead of now: the monotonic clock of that process"):
        rules.predicates.update({"free": True, "locked": True, "closed": True}, 103 * S, 100 * S)
    grip = rules.hello("grip", TOKEN, GRIP, (), 100 * S)
    for stamp, said in (
        (1 * S, "99 s ago by its stamp; the monotonic clock"),
        (99 * S, "no process that reads"),
    ):
        rules.predicates.update({"free": True, "locked": True, "closed": True}, stamp, 100 * S)
        with pytest.raises(LineRefusedError, match=said):
            rules.write(grip, {BOTTOM: True}, None, 100 * S)
