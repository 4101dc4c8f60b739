"""The rules of the line arbiter, in virtual time: one write, one writer, IL-01, IL-03, IL-05, IL-10."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.arbiter import Policy
from end_effector_hal.arbiter.protocol import LastWillRunsError
from end_effector_hal.arbiter.rules._policy import Exclusion
from end_effector_hal.errors import LineBusyError, LineRefusedError, UsageError, WireError
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import (
    BOTTOM,
    CYLINDER,
    GRIP,
    LINES,
    MS,
    POLICY,
    TOP,
    UNLOCK,
    S,
)
from tests.unit.arbiter.virtual_arbiter import UNWIND, Arbiter


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


def test_il_10_counts_from_the_end_of_a_write():
    """Writing takes a moment: counted from before, the wire would stay as it is for less."""
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.rules.written(1 * S + 2 * MS)
    arbiter.to(1 * S + 10 * MS)
    arbiter.rules.written(1 * S + 10 * MS)  # nothing was written since
    assert arbiter.set(arbiter.grip, bottom=False) == 42 * MS


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


def test_il_08_one_write_does_not_end_suction_and_begin_blowing():
    """What a program could not write before it tries again, with what it wants by now."""
    pause = 50 * MS
    policy = Policy(LINES, [Exclusion(BOTTOM, TOP, "IL-08", "IL-08", pause)])
    arbiter = Arbiter(policy)
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(2 * S)
    with pytest.raises(LineRefusedError, match=r"IL-08: .* while .* is active"):
        arbiter.set(arbiter.grip, bottom=False, top=True)
    assert arbiter.rules.levels[BOTTOM]
    arbiter.set(arbiter.grip, bottom=False)
    with pytest.raises(LineRefusedError, match="within 50 ms"):
        arbiter.set(arbiter.grip, top=True)
    arbiter.to(2 * S + pause)
    arbiter.set(arbiter.grip, top=True)


def test_an_activation_that_failed_half_way_counts_as_active_until_a_write_succeeds():
    """Of two chips the first may have been written when the second fails; then nobody may rely on the level."""
    longest = 3 * S
    policy = Policy(LINES, [Exclusion(BOTTOM, TOP, "IL-08", "IL-08")], max_active_us={BOTTOM: longest})
    arbiter = Arbiter(policy)
    arbiter.lines.error = OSError(5, "Input/output error")
    with pytest.raises(WireError):
        arbiter.set(arbiter.grip, bottom=True)
    arbiter.lines.state[BOTTOM], arbiter.lines.error = True, None  # it was written all the same
    with pytest.raises(LineRefusedError, match="IL-08"):
        arbiter.set(arbiter.grip, top=True)
    assert arbiter.rules.deadline <= 1 * S + longest  # the longest time has begun
    arbiter.set(arbiter.grip, bottom=False)
    assert not arbiter.lines.state[BOTTOM], "no change is written only where the level is known"
    arbiter.set(arbiter.grip, top=True)


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
    with pytest.raises(LineRefusedError, match=r"IL-10: too many pending writes \(at most 64"):
        arbiter.set(arbiter.grip, bottom=False)


def test_a_write_of_no_line_says_how_long_others_wait_and_takes_no_place():
    arbiter = Arbiter()
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.set(arbiter.grip, bottom=False)
    arbiter.set(arbiter.grip, bottom=True)
    assert {arbiter.set(arbiter.grip, UNWIND) for _ in range(65)} == {100 * MS}
    assert len(arbiter.grip.queue) == 2
    arbiter.to(1 * S + 100 * MS)
    assert arbiter.set(arbiter.grip) == 0


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


def test_one_write_does_not_end_one_and_begin_the_other():
    arbiter = Arbiter(Policy(LINES, [(BOTTOM, TOP)]))
    arbiter.set(arbiter.grip, bottom=True)
    arbiter.to(2 * S)
    with pytest.raises(LineRefusedError, match="IL-05"):
        arbiter.set(arbiter.grip, bottom=False, top=True)
    assert arbiter.rules.levels[BOTTOM]
    arbiter.set(arbiter.grip, bottom=False)
    assert arbiter.set(arbiter.grip, top=True) == 0


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
    (why,) = arbiter.rules.predicates.faults.values()
    assert why.startswith(
        "IL-03: unlock (tool changer) was active for its longest time and cannot be deactivated: "
    )
    with pytest.raises(LineRefusedError):
        arbiter.rules.reset(arbiter.now)
    arbiter.lines.error = None
    arbiter.to(9 * S)
    assert [at for at, *_ in arbiter.written] == [1 * S, 5 * S + 100_000]
    assert len(arbiter.rules.trips) == 0, "the reset cleared them, and a further try is none"
    assert list(arbiter.rules.predicates.faults.values()) == [why]


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
