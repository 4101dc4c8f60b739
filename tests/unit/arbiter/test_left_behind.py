"""Lines that were active when the description changed, and how long an activation lasts through a restart."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.records import NO_ANSWER, Records
from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._records import recall
from end_effector_hal.arbiter.rules._coils import SecondCoil
from end_effector_hal.arbiter.rules._lines import left_behind
from end_effector_hal.arbiter.rules._policy import Role
from end_effector_hal.arbiter.rules._session import ArbiterState, DrivenLine, read_arbiter_state
from end_effector_hal.errors import LineRefusedError, UsageError
from tests.support.keeping import BOTTOM, CYLINDER, GRIP, MS, TOKEN, TOP, UNLOCK, Lines, S
from tests.support.keeping import POLICY as WITHOUT_ROLES
from tests.unit.arbiter.test_coils import BACK, CUP, JAW, Wires

ROLES = {
    UNLOCK: Role("unlock"),
    BOTTOM: Role("bottom (vacuum)"),
    CYLINDER: Role("cylinder (cylinder)"),
    TOP: Role("top (vacuum)"),
}
POLICY = replace(WITHOUT_ROLES, roles=ROLES)


def left(**active: bool) -> ArbiterState:
    """What an arbiter has left in its record, through JSON."""
    state = LineArbiter(Lines(**active), POLICY, 0, ArbiterState(driven=roles(False))).state
    return read_arbiter_state(json.loads(json.dumps(state.as_json())))


def roles(active: bool | None) -> dict[str, DrivenLine]:
    return {line: DrivenLine(role.words, active) for line, role in ROLES.items()}


def changed(**words: str) -> Policy:
    """Other roles: None is no output any more."""
    given = {line: Role(words.get(line, role.words)) for line, role in ROLES.items()}
    return replace(POLICY, roles={line: role for line, role in given.items() if role.words})


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({TOP: ""}, "top was top (vacuum) and is no output in this description"),
        ({TOP: "unlock", UNLOCK: "top (vacuum)"}, "top was top (vacuum) and is unlock in this description"),
        ({TOP: "blow-off of bottom"}, "is blow-off of bottom"),
        ({TOP: "top (gripper)"}, "is top (gripper)"),
        ({TOP: "lamp"}, "is lamp"),
        ({TOP: "top (vacuum) with the second coil B"}, "with the second coil B"),
    ],
)
def test_a_line_that_is_active_keeps_its_role_or_the_description_is_refused(
    words: dict[str, str], said: str
) -> None:
    lines, policy = Lines(top=True, bottom=True), changed(**words)
    with pytest.raises(UsageError, match="The description has changed while an output is") as refused:
        LineArbiter(lines, policy, 1 * S, left(top=True, bottom=True))
    assert said in str(refused.value)
    assert "Drop first" in str(refused.value)
    assert lines.written == []
    LineArbiter(Lines(bottom=True), policy, 1 * S, left(bottom=True))
    LineArbiter(Lines(top=True), POLICY, 1 * S, left(top=True))


def test_in_doubt_any_line_may_be_active() -> None:
    doubted = recall(replace(left(), doubt="it is torn"), JournalEntry({}))
    assert "top was top" in left_behind(doubted, changed(top=""))
    assert not left_behind(doubted, POLICY)
    assert not left_behind(recall(left(), JournalEntry({})), changed(top=""))


def test_without_a_session_record_the_journal_has_the_roles() -> None:
    journal = JournalEntry({}, clean=True, boot="now", driven=roles(None))
    assert left_behind(recall(None, journal, "now"), changed(top=""))
    assert left_behind(recall(None, journal, ""), changed(top="")), "nobody knows which start this is"
    assert not left_behind(recall(None, journal, "later"), changed(top="")), (
        "a restart resets the lines of the board"
    )


@pytest.mark.parametrize(
    ("active", "clean", "doubt", "refused"),
    [
        (True, True, "", True),
        (False, True, "", False),
        (False, False, "", True),
        (False, True, "it is torn", True),
    ],
)
def test_a_device_that_keeps_its_position_is_known_through_a_loss_of_power(
    active: bool, clean: bool, doubt: str, refused: bool
) -> None:
    driven = {TOP: DrivenLine("top (vacuum)", active)}
    journal = JournalEntry({}, clean=clean, boot="before", doubt=doubt, driven=driven)
    assert bool(left_behind(recall(None, journal, "now"), changed(top=""))) is refused


def test_without_any_roles_an_unlock_waits_for_a_reset() -> None:
    state = recall(ArbiterState(doubt="it is torn"), JournalEntry({}, doubt="it is damaged"), "now")
    new = LineArbiter(Lines(), POLICY, 0, state)
    changer = new.hello("changer", TOKEN, (UNLOCK,), (), 0)
    with pytest.raises(LineRefusedError, match=r"IL-01: .*No record says what the lines drove"):
        new.write(changer, {UNLOCK: True}, None, 0)
    new.reset(0)
    new.write(changer, {UNLOCK: True}, None, 0)


def test_an_unlock_lasts_3_s_through_a_restart() -> None:
    first = LineArbiter(Lines(), POLICY, 0, ArbiterState(driven=roles(False)))
    changer = first.hello("changer", TOKEN, (UNLOCK,), (), 0)
    first.write(changer, {UNLOCK: True}, None, 100 * MS)
    lines = Lines(unlock=True)
    new = LineArbiter(lines, POLICY, 2 * S, first.state)
    new.advance(3_099 * MS)
    assert new.levels[UNLOCK]
    new.advance(3_100 * MS)
    assert not new.levels[UNLOCK]


@pytest.mark.parametrize("since", [{}, {UNLOCK: 9 * S}])
def test_an_unlock_of_which_the_time_is_not_known_ends_at_once(since: dict[str, int]) -> None:
    """The record was torn, or the clock has jumped back."""
    new = LineArbiter(Lines(unlock=True), POLICY, 2 * S, ArbiterState(driven=roles(True), since=since))
    new.advance(2 * S)
    assert not new.levels[UNLOCK]


def test_a_line_that_no_record_knows_is_held_until_a_reset() -> None:
    """It unlocks by this description; by the former one it may have held the part."""
    new = LineArbiter(Lines(unlock=True), POLICY, 0, recall(None, JournalEntry({}), "now"))
    new.advance(9 * S)
    assert new.levels[UNLOCK]
    assert "no record says what it drove" in new.predicates.faults["IL-03 unlock"]
    grip = new.hello("grip", TOKEN, GRIP, (), 9 * S)
    with pytest.raises(LineRefusedError, match="IL-05"):
        new.write(grip, {TOP: True}, None, 9 * S)
    new.reset(9 * S)
    new.advance(9 * S)
    assert not new.levels[UNLOCK]


def test_a_line_that_no_record_knew_has_its_longest_time_again_once_it_was_written() -> None:
    new = LineArbiter(Lines(unlock=True), POLICY, 0, recall(None, JournalEntry({}), "now"))
    changer = new.hello("changer", TOKEN, (UNLOCK,), (), 0)
    for at, level in ((1 * S, False), (2 * S, True)):
        new.write(changer, {UNLOCK: level}, None, at)
        new.advance(at)
        assert new.levels[UNLOCK] is level
    new.advance(5 * S)
    assert not new.levels[UNLOCK]


@pytest.mark.parametrize("level", [True, False])
def test_a_guess_that_no_record_knows_is_latched_only_where_it_turns_out_to_be_active(level: bool) -> None:
    """Two coils, both inactive: it was not found active, and a first start has no alarm of it."""
    both = {JAW: SecondCoil(BACK)}
    policy = Policy((JAW, CUP), (), {JAW: 3 * S}, opposites=both, roles={JAW: Role("unlock")})
    new = LineArbiter(Wires(), policy, 0, recall(None, JournalEntry({}), "now"))
    changer = new.hello("changer", TOKEN, (JAW,), (), 0)
    new.advance(4 * S)
    assert new.levels[JAW]
    assert not new.predicates.faults
    new.write(changer, {JAW: level}, None, 4 * S)
    new.advance(9 * S)
    assert new.levels[JAW] is level
    assert bool(new.predicates.faults) is level


@pytest.mark.parametrize(
    ("late", "said"),
    [
        (JournalEntry({}, boot="now", driven=roles(None)), "top was top"),
        (JournalEntry({}, doubt="it is damaged"), "No record says"),
        (JournalEntry({}, boot="before", driven=roles(None)), ""),
    ],
)
def test_a_journal_that_comes_late_refuses_an_unlock(late: JournalEntry, said: str) -> None:
    """The disk did not answer at the start, and there is no session record."""

    class Sessions:
        boot, trouble = "now", ""
        read = begin = keep = staticmethod(lambda *_: None)

    class Slow:
        trouble = ""
        read = staticmethod(lambda: NO_ANSWER)
        late = staticmethod(lambda: late)
        keep = staticmethod(lambda *_: None)

    records = Records(Sessions(), Slow())  # type: ignore[arg-type]
    arbiter = LineArbiter(Lines(), changed(top=""), 0, records.before)
    assert "former lines" not in arbiter.predicates.faults
    records.keep(arbiter)
    assert said in arbiter.predicates.faults.get("former lines", "")
    assert bool(said) is ("former lines" in arbiter.predicates.faults)
