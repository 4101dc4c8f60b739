"""What a new line arbiter makes of what the one before it has left."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from end_effector_hal.arbiter import LineArbiter
from end_effector_hal.arbiter.protocol import LastWillRunsError
from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._records import recall
from end_effector_hal.arbiter.rules._lines import UNKNOWN_ROLES
from end_effector_hal.arbiter.rules._session import ArbiterState, SessionRecord, read_arbiter_state
from end_effector_hal.errors import LineBusyError, LineRefusedError
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import (
    BOTTOM,
    CYLINDER,
    GRIP,
    LINES,
    MS,
    OTHER,
    POLICY,
    SENSING,
    TOKEN,
    TOP,
    UNLOCK,
    Lines,
    S,
)

UNWIND = (LastWillStep(TOP), LastWillStep(BOTTOM, after_us=2 * S))
GRIPPING = SessionRecord("grip", TOKEN, GRIP, UNWIND, ended=False, pid=7)
E_STOP = {"closed": "IL-13: the e-stop was opened."}
IL_03 = {"IL-03 unlock": "IL-03: unlock was active too long."}


def rules(
    *clients: SessionRecord, faults: dict[str, str] | None = None, **active: bool
) -> tuple[LineArbiter, Lines]:
    lines = Lines(**active)
    return LineArbiter(lines, POLICY, 0, ArbiterState(faults or {}, clients, clean=False)), lines


def test_a_client_that_comes_back_goes_on() -> None:
    new, lines = rules(GRIPPING, bottom=True, top=True)
    session = new.hello("grip", TOKEN, GRIP, UNWIND, 500 * MS)
    new.expire(1 * S)
    assert new.sessions == [session]
    assert lines.written == []
    new.write(session, {CYLINDER: True}, None, 1 * S)


def test_a_client_that_does_not_come_back_is_dead_and_its_will_is_done() -> None:
    new, lines = rules(GRIPPING, bottom=True, top=True)
    assert new.deadline == 1 * S
    assert new.expire(1 * S - 1) == []
    new.expire(1 * S)
    new.advance(1 * S)
    assert new.levels[BOTTOM]
    assert not new.levels[TOP]
    new.advance(3 * S)
    assert lines.written == [(0, TOP, False), (0, BOTTOM, False)]
    assert new.sessions == []


def test_a_client_that_was_started_again_meanwhile_finds_the_will_executed() -> None:
    new, _ = rules(GRIPPING, bottom=True, top=True)
    with pytest.raises(LastWillRunsError, match="the last will of grip is being executed"):
        new.hello("grip", OTHER, GRIP, (), 100 * MS)
    new.advance(2_100 * MS)
    assert not new.levels[BOTTOM]
    new.hello("grip", OTHER, GRIP, (), 2_100 * MS)


def test_a_deactivation_that_waited_when_both_died_is_done_by_the_next_arbiter() -> None:
    """IL-10: the line had just changed. Its program had accepted a cancel; its last will is about the others."""
    old, lines = rules(bottom=True)
    session = old.hello("grip", TOKEN, GRIP, (), 1 * S)
    old.write(session, {TOP: True}, (LastWillStep(TOP), LastWillStep(BOTTOM)), 1 * S)
    assert old.write(session, {TOP: False}, (LastWillStep(BOTTOM),), 1 * S + 10 * MS) == 40 * MS
    old.declare_dead(session, "killed", 1 * S + 20 * MS)
    assert lines.state[TOP]
    new = LineArbiter(lines, POLICY, 2 * S, replace(old.state, clean=False))
    new.advance(3 * S)
    assert not lines.state[TOP]
    assert not lines.state[BOTTOM]


def test_a_pid_does_not_tell_who_comes_back() -> None:
    """In PID namespaces of their own, as in containers, all clients have pid 0."""
    new, _ = rules(GRIPPING._replace(pid=0), bottom=True, top=True)
    with pytest.raises(LastWillRunsError, match="the last will of grip is being executed"):
        new.hello("grip", OTHER, GRIP, (), 100 * MS, pid=0)
    new.advance(2_100 * MS)
    assert new.levels == dict.fromkeys(LINES, False)
    session = new.hello("grip", OTHER, GRIP, UNWIND, 2_100 * MS, pid=0)
    assert not session.declared_dead
    with pytest.raises(LineBusyError, match=r"belongs to grip \(in another container\)"):
        new.hello("other", TOKEN, GRIP, (), 2_100 * MS, pid=0)


def test_what_was_held_stays_held_through_the_death_of_both() -> None:
    new, lines = rules(GRIPPING._replace(will=()), bottom=True, top=True)
    new.expire(10 * S)
    new.advance(10 * S)
    assert lines.written == []
    assert new.hello("grip", OTHER, GRIP, (), 10 * S)


def test_a_will_that_was_being_executed_is_executed_to_its_end() -> None:
    new, _ = rules(GRIPPING._replace(ended=True), bottom=True)
    with pytest.raises(LastWillRunsError):
        new.hello("grip", TOKEN, GRIP, (), 0)
    new.advance(2 * S)
    assert new.levels == dict.fromkeys(LINES, False)


def test_lines_that_this_arbiter_has_not_are_forgotten() -> None:
    elsewhere = SessionRecord(
        "grip", TOKEN, ("elsewhere", TOP), (LastWillStep("elsewhere"), LastWillStep(TOP)), ended=False
    )
    new, lines = rules(elsewhere, top=True)
    new.expire(1 * S)
    new.advance(1 * S)
    assert lines.written == [(0, TOP, False)]


def test_faults_stay_latched_through_a_restart() -> None:
    new = LineArbiter(Lines(), SENSING, 0, ArbiterState(E_STOP))
    new.predicates.update({"free": True, "locked": True, "closed": True}, 0, 0)
    session = new.hello("grip", TOKEN, GRIP, (), 0)
    with pytest.raises(LineRefusedError, match="the e-stop was opened; reset the faults first"):
        new.write(session, {BOTTOM: True}, None, 0)
    assert new.state.faults == E_STOP
    new.reset(0)
    new.write(session, {BOTTOM: True}, None, 0)
    assert new.state.faults == {}


def test_what_a_client_has_latched_is_its_own_through_a_restart_of_the_arbiter() -> None:
    policy = replace(SENSING, faults={"sensor_fault": "changer"})
    first = LineArbiter(Lines(), policy, 0)
    first.latch(first.hello("changer", TOKEN, (UNLOCK,), (), 0), "sensor_fault", "why")
    state = read_arbiter_state(json.loads(json.dumps(first.state.as_json())))
    new = LineArbiter(Lines(), policy, 0, state)
    stays = {"sensor_fault": "changer has latched sensor_fault, and has not been reset."}
    assert new.reset(0) == stays, "it may come back"
    client = new.hello("changer", TOKEN, (UNLOCK,), (), 0)
    assert new.reset(0) == stays
    new.clear(client, "sensor_fault")
    assert new.state.faults == {}

    new = LineArbiter(Lines(), policy, 0, state)
    client = new.hello("changer", TOKEN, (UNLOCK,), (), 0, faults={})
    assert new.state.faults == {}, "it was cleared while no arbiter was there"
    new.reset(0)
    new = LineArbiter(Lines(), policy, 0, state)
    new.expire(policy.lease_us)
    new.reset(policy.lease_us)
    assert new.state.faults == {}, "the client has gone"


def test_the_memory_is_what_the_next_one_needs() -> None:
    first = LineArbiter(Lines(), POLICY, 0)
    session = first.hello("grip", TOKEN, GRIP, (), 100 * MS)
    first.write(session, {BOTTOM: True}, UNWIND, 100 * MS)
    changer = first.hello("changer", OTHER, (UNLOCK,), (), 100 * MS)
    left = SessionRecord("grip", TOKEN, tuple(sorted(GRIP)), UNWIND, ended=False)
    clients = (left, SessionRecord("changer", OTHER, (UNLOCK,), (), ended=False))
    active = dict.fromkeys(LINES, False) | {BOTTOM: True}
    assert first.state == ArbiterState({}, clients, clean=False, levels=active)
    first.bye(changer, (), 200 * MS)
    first.declare_dead(session, "killed", 200 * MS)
    assert first.state.clients == (left._replace(ended=True),)
    assert first.state.dead == (("grip", TOKEN),)
    first.advance(9 * S)
    inactive = dict.fromkeys(LINES, False)
    assert first.state == ArbiterState(clean=False, levels=inactive, dead=(("grip", TOKEN),))


def test_il_03_is_told_until_a_reset_also_after_a_restart() -> None:
    first = LineArbiter(Lines(), POLICY, 0)
    changer = first.hello("changer", OTHER, (UNLOCK,), (), 100 * MS)
    first.write(changer, {UNLOCK: True}, None, 100 * MS)
    first.advance(100 * MS + 3 * S)
    faults = first.state.faults
    assert faults == {
        "IL-03 unlock": "IL-03: unlock (tool changer) was active for its longest time and was deactivated."
    }
    second = LineArbiter(Lines(), POLICY, 0, ArbiterState(faults))
    assert second.state.faults == faults
    changer = second.hello("changer", OTHER, (UNLOCK,), (), 100 * MS)
    second.write(changer, {UNLOCK: True}, None, 100 * MS)
    second.reset(200 * MS)
    assert second.state.faults == {}


def test_in_doubt_no_will_is_executed() -> None:
    lines = Lines(bottom=True, top=True)
    doubted = ArbiterState(
        {}, (GRIPPING, GRIPPING._replace(client="other", ended=True)), False, doubt="it is torn"
    )
    new = LineArbiter(lines, POLICY, 0, doubted)
    new.expire(10 * S)
    new.advance(20 * S)
    assert lines.written == []
    assert new.predicates.faults == {
        "last wills": "No last will was executed, because it is torn: what was active stays active."
    }
    assert new.hello("grip", OTHER, GRIP, (), 20 * S)


def test_a_record_of_other_levels_is_outdated() -> None:
    """Somebody has written the lines meanwhile: the wills are of another part."""
    for changed in (BOTTOM, CYLINDER):
        found = dict.fromkeys(LINES, False) | {BOTTOM: True, TOP: True}
        lines = Lines(bottom=True, top=True)
        memory = ArbiterState(
            {}, (GRIPPING,), levels={**found, changed: not found[changed], "elsewhere": True}
        )
        new = LineArbiter(lines, POLICY, 0, memory)
        new.expire(10 * S)
        new.advance(20 * S)
        assert lines.written == []
        said = dict(new.predicates.faults)
        assert f"{changed} was changed while no line arbiter ran" in said.pop("last wills")
        let_go = "cylinder went inactive while no line arbiter ran: what it held has been let go."
        assert said == ({"let go": let_go} if changed == CYLINDER else {})


@pytest.mark.parametrize("clients", [(), (GRIPPING,), (GRIPPING._replace(will=()),)])
def test_a_doubt_is_a_fault_where_a_line_is_active(clients: tuple[SessionRecord, ...]) -> None:
    """Also with an empty will: it may be outdated, too."""
    memory = ArbiterState({}, clients, doubt="it is torn")
    assert not LineArbiter(Lines(), POLICY, 0, memory).predicates.faults
    assert list(LineArbiter(Lines(bottom=True), POLICY, 0, memory).predicates.faults) == ["last wills"]


def test_what_waits_to_be_deactivated_stands_before_the_will() -> None:
    first = LineArbiter(Lines(), POLICY, 0)
    session = first.hello("grip", TOKEN, GRIP, (), 100 * MS)
    first.write(session, {BOTTOM: True, TOP: True}, UNWIND, 100 * MS)
    first.write(session, {TOP: False}, (LastWillStep(BOTTOM, after_us=2 * S),), 110 * MS)
    (left,) = first.state.clients
    assert left.will == (LastWillStep(TOP), LastWillStep(BOTTOM, after_us=2 * S))


def test_a_client_that_was_declared_dead_is_told_so_by_the_next_arbiter() -> None:
    first = LineArbiter(Lines(), POLICY, 0)
    first.declare_dead(first.hello("grip", TOKEN, GRIP, (), 0), "killed", 0)
    second = LineArbiter(Lines(), POLICY, 1 * S, first.state)
    assert second.hello("grip", TOKEN, GRIP, (), 1 * S).declared_dead


# Which of the two files is believed

RECORD = ArbiterState(E_STOP, (GRIPPING,), clean=False)


def test_the_record_of_this_boot_is_believed() -> None:
    assert recall(RECORD, JournalEntry(IL_03, clean=False, boot="now")) == RECORD
    assert recall(RECORD, JournalEntry({}, doubt="it is damaged")) == RECORD


def test_without_a_record_the_faults_are_those_of_the_journal_and_nothing_is_executed() -> None:
    found = recall(None, JournalEntry(E_STOP, clean=False, boot="before"))
    assert (found.faults, found.clean) == (E_STOP, False)
    assert recall(None, JournalEntry({}, doubt="it is damaged")).faults == {
        "journal": "Faults that were latched before the start may be missing: it is damaged.",
        "former lines": UNKNOWN_ROLES.format("it is damaged"),
    }


def test_without_a_record_it_is_a_doubt_what_was_left_unless_the_one_before_ended_in_order() -> None:
    assert not recall(None, JournalEntry({}, clean=True, boot="any")).doubt
    for journal in (
        JournalEntry({}),
        JournalEntry({}, clean=False, boot="any"),
        JournalEntry({}, doubt="it is damaged"),
    ):
        assert recall(None, journal).doubt == "no session record was found"


def test_in_doubt_the_faults_of_both_files_are_latched() -> None:
    doubted = replace(RECORD, doubt="it is torn")
    found = recall(doubted, JournalEntry(IL_03, clean=False, boot="now"))
    assert found == replace(doubted, faults={**E_STOP, **IL_03})
