"""Last wills in virtual time: executed in order and in time, by whoever dies or leaves."""

import pytest

from end_effector_hal.arbiter.protocol import LastWillRunsError
from end_effector_hal.errors import LineBusyError, LineRefusedError, WireError
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import (
    BOTTOM,
    CYLINDER,
    GRIP,
    MS,
    TOP,
    UNLOCK,
    S,
)
from tests.unit.arbiter.virtual_arbiter import UNWIND, Arbiter


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


def test_a_step_of_a_will_that_fails_is_tried_again_before_those_behind_it():
    arbiter = gripped(UNWIND)
    arbiter.lines.error = OSError(5, "Input/output error")
    arbiter.die(arbiter.grip)
    arbiter.to(arbiter.now + 5 * S)  # longer than all of it takes
    assert arbiter.written == []
    assert "cannot be deactivated" in " ".join(arbiter.rules.predicates.faults.values())
    arbiter.lines.error = None
    arbiter.to(arbiter.now + 10 * S)
    assert [line for _, line, _ in arbiter.written] == [TOP, CYLINDER, BOTTOM]


def test_a_last_will_that_fails_is_told_to_whoever_starts():
    arbiter = gripped(UNWIND)
    arbiter.lines.error = OSError(5, "Input/output error")
    arbiter.die(arbiter.grip)
    arbiter.to(arbiter.now + S)
    with pytest.raises(LineBusyError, match=r"the last will of grip cannot be executed.*Input/output error"):
        arbiter.hello("grip", GRIP)
    arbiter.lines.error = None
    arbiter.to(arbiter.now + 10 * S)
    assert arbiter.hello("grip", GRIP).client == "grip"


def whose_lines_fail():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(2 * S)
    arbiter.written.clear()
    arbiter.lines.error = OSError(5, "Input/output error")
    return arbiter


def test_nothing_is_activated_behind_a_deactivation_that_fails():
    """Its interlocks would have been asked long before the hardware works again."""
    arbiter = whose_lines_fail()
    arbiter.set(arbiter.grip, bottom=False)
    with pytest.raises(LineRefusedError, match=r"IL-11.*cannot be deactivated"):
        arbiter.set(arbiter.grip, top=True)
    arbiter.lines.error = None
    arbiter.to(3 * S)
    assert [line for _, line, _ in arbiter.written] == [BOTTOM]
    arbiter.set(arbiter.grip, top=True)


def test_what_waited_to_be_activated_is_forgotten_when_a_deactivation_fails():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(1 * S + 60 * MS)
    arbiter.set(arbiter.grip, bottom=False)
    arbiter.to(1 * S + 70 * MS)
    assert arbiter.set(arbiter.grip, bottom=False, cylinder=True) == 0
    arbiter.to(1 * S + 80 * MS)
    arbiter.written.clear()
    assert arbiter.set(arbiter.grip, cylinder=False, top=True) > 0, "the cylinder settles"
    arbiter.lines.error = OSError(5, "Input/output error")
    arbiter.to(2 * S)
    assert "cannot be deactivated" in " ".join(arbiter.rules.predicates.faults.values())
    arbiter.lines.error = None
    arbiter.to(3 * S)
    assert [(line, level) for _, line, level in arbiter.written] == [(CYLINDER, False)]


def test_a_deactivation_beside_an_activation_that_fails_at_once_is_tried_again():
    arbiter = whose_lines_fail()
    with pytest.raises(WireError, match="Input/output error"):
        arbiter.set(arbiter.grip, bottom=False, top=True)
    arbiter.lines.error = None
    arbiter.to(3 * S)
    assert [(line, level) for _, line, level in arbiter.written] == [(BOTTOM, False)]
