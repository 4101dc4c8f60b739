"""Outputs of two coils: held valves and bistable ones, in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.records._journal import Journal, JournalEntry
from end_effector_hal.arbiter.records._records import recall
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.arbiter.rules._coils import SecondCoil
from end_effector_hal.arbiter.rules._session import ArbiterState, read_arbiter_state
from end_effector_hal.errors import UsageError, WireError
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import MS, TOKEN, S

JAW, BACK, CUP = "jaw", "back", "cup"
HELD = Policy((JAW, CUP), opposites={JAW: SecondCoil(BACK)})
PULSED = Policy((JAW, CUP), opposites={JAW: SecondCoil(BACK, 100 * MS)})


class Wires:
    """Three lines, each with its level; notes every write and refuses to have both coils active."""

    def __init__(self, **active: bool) -> None:
        self.now, self.written = 0, list[tuple[int, str, bool]]()
        self.state = dict.fromkeys((JAW, CUP, BACK), False) | active
        self.error: Exception | None = None

    def request(self, names: object) -> dict[str, bool]:
        assert list(names) == [JAW, CUP, BACK]
        return dict(self.state)

    def levels(self) -> dict[str, bool]:
        return dict(self.state)

    def set(self, levels: dict[str, bool]) -> None:
        if self.error:
            raise self.error
        for line, level in levels.items():
            self.state[line] = level
            self.written.append((self.now, line, level))
        assert not (self.state[JAW] and self.state[BACK])

    def close(self) -> None:
        pass


class Running:
    """An arbiter with one client that lives as long as it is told."""

    def __init__(self, policy: Policy, state: ArbiterState | None = None, **active: bool) -> None:
        self.wires = Wires(**active)
        self.rules = LineArbiter(self.wires, policy, 0, state)
        self.session = self.rules.hello("grip", TOKEN, (JAW, CUP), (LastWillStep(JAW),), 0)
        self.lives = True
        self.to(1 * S)

    def to(self, at: int) -> None:
        while self.wires.now < at:
            if self.lives:
                self.rules.renew(self.session, self.wires.now)
            due = self.rules.deadline
            step = self.wires.now + 500 * MS if due is None else max(due, self.wires.now + 1)
            self.wires.now = min(at, step, self.wires.now + 500 * MS)
            self.rules.expire(self.wires.now)
            self.rules.advance(self.wires.now)

    def set(self, **levels: bool) -> None:
        self.rules.write(self.session, levels, None, self.wires.now)


def test_one_coil_of_a_held_valve_is_active_and_the_other_ends_before() -> None:
    arbiter = Running(HELD, back=True)
    arbiter.set(jaw=True)
    arbiter.to(2 * S)
    arbiter.set(jaw=False)
    assert arbiter.wires.written == [
        (1 * S, BACK, False),
        (1 * S, JAW, True),
        (2 * S, JAW, False),
        (2 * S, BACK, True),
    ]
    assert arbiter.rules.levels == arbiter.rules.read_levels() == {JAW: False, CUP: False}


@pytest.mark.parametrize(
    ("active", "level"), [({JAW: True}, True), ({BACK: True}, False), ({JAW: True, BACK: True}, True)]
)
def test_a_held_valve_is_adopted_as_it_stands(active: dict[str, bool], level: bool) -> None:
    arbiter = Running(HELD, **active)
    assert arbiter.rules.read_levels()[JAW] is level
    assert not (arbiter.wires.state[JAW] and arbiter.wires.state[BACK])
    assert arbiter.wires.state[JAW] is level


def test_of_a_held_valve_without_a_level_nothing_is_known_until_somebody_writes_it() -> None:
    arbiter = Running(HELD)
    assert arbiter.rules.levels[JAW], "a part may be held"
    assert arbiter.rules.read_levels() == {CUP: False}
    assert arbiter.wires.written == [], "a start drives nothing"
    arbiter.set(jaw=False)
    assert arbiter.rules.read_levels() == {JAW: False, CUP: False}
    assert arbiter.wires.state == {JAW: False, CUP: False, BACK: True}


def test_a_held_valve_without_a_level_that_is_taken_as_active_is_not_driven_and_reads_so() -> None:
    arbiter = Running(HELD)
    arbiter.set(jaw=True)
    assert arbiter.wires.written == [], "nothing is activated by itself (IL-11)"
    assert arbiter.rules.levels == arbiter.rules.read_levels() == {JAW: True, CUP: False}
    arbiter.set(jaw=False)
    assert arbiter.rules.read_levels()[JAW] is False
    assert arbiter.wires.state[BACK]


def test_a_bistable_valve_gets_a_pulse_at_each_change() -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True, cup=True)
    arbiter.to(2 * S)
    assert arbiter.rules.levels == arbiter.rules.read_levels() == {JAW: True, CUP: True}
    arbiter.set(jaw=False)
    arbiter.to(3 * S)
    jaw_and_back = [each for each in arbiter.wires.written if each[1] != CUP]
    assert jaw_and_back == [
        (1 * S, BACK, False),
        (1 * S, JAW, True),
        (1 * S + 100 * MS, JAW, False),
        (2 * S, JAW, False),
        (2 * S, BACK, True),
        (2 * S + 100 * MS, BACK, False),
    ]


def test_a_pulse_is_cut_short_by_the_way_back() -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    arbiter.to(1 * S + 10 * MS)
    arbiter.set(jaw=False)  # IL-10: 50 ms after the last change
    arbiter.to(2 * S)
    assert arbiter.wires.written[2:] == [
        (1 * S + 50 * MS, JAW, False),
        (1 * S + 50 * MS, BACK, True),
        (1 * S + 150 * MS, BACK, False),
    ]


RESTING = Policy((JAW, CUP), opposites={JAW: SecondCoil(BACK, 100 * MS, 300 * MS)})


def test_with_a_pause_a_change_waits_for_the_whole_pulse_and_the_pause_after_it() -> None:
    arbiter = Running(RESTING, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    arbiter.to(1 * S + 10 * MS)
    assert arbiter.rules.write(arbiter.session, {JAW: False}, None, arbiter.wires.now) == 390 * MS
    arbiter.to(3 * S)
    assert arbiter.wires.written[2:] == [
        (1 * S + 100 * MS, JAW, False),
        (1 * S + 400 * MS, JAW, False),
        (1 * S + 400 * MS, BACK, True),
        (1 * S + 500 * MS, BACK, False),
    ]


def test_the_pause_is_counted_from_the_real_end_of_the_pulse() -> None:
    arbiter = Running(RESTING, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    arbiter.wires.error = WireError("the chip is gone.")
    arbiter.to(1 * S + 150 * MS)
    arbiter.wires.error = None
    arbiter.set(jaw=False)
    arbiter.to(3 * S)
    ended = next(at for at, line, level in arbiter.wires.written[2:] if (line, level) == (JAW, False))
    assert ended == 1 * S + 200 * MS
    assert (ended + 300 * MS, BACK, True) in arbiter.wires.written


def test_an_arbiter_that_waked_late_ends_the_pulse_and_then_waits_for_the_pause() -> None:
    arbiter = Running(RESTING, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    arbiter.set(jaw=False)
    arbiter.rules.renew(arbiter.session, 1900 * MS)
    arbiter.wires.now = 1900 * MS
    arbiter.rules.advance(1900 * MS)
    assert arbiter.wires.state == {JAW: False, CUP: False, BACK: False}
    arbiter.to(2200 * MS)
    assert arbiter.wires.state[BACK]


def test_a_start_waits_for_the_pause_for_nobody_knows_when_the_last_pulse_was() -> None:
    rules = LineArbiter(Wires(), RESTING, 0, ArbiterState(pulsed={JAW: True}))
    session = rules.hello("grip", TOKEN, (JAW, CUP), (), 0)
    assert rules.write(session, {JAW: False}, None, 10 * MS) == 290 * MS


def test_the_last_will_waits_for_the_pause_as_well() -> None:
    arbiter = Running(RESTING, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    arbiter.rules.declare_dead(arbiter.session, "it was killed", arbiter.wires.now)
    arbiter.lives = False
    arbiter.to(3 * S)
    assert (1 * S + 400 * MS, BACK, True) in arbiter.wires.written


def test_a_bistable_valve_of_which_nothing_is_known_counts_as_active() -> None:
    first = Running(PULSED, ArbiterState(doubt="no session record was found"))
    assert first.rules.levels[JAW], "a part may be held"
    assert not first.rules.predicates.faults, "there was no last will"
    assert JAW not in first.rules.read_levels(), "who adopts decides by the sensors"
    assert first.rules.state.pulsed == {}, "a guess is no record"
    assert not Running(PULSED, ArbiterState(pulsed={JAW: False})).rules.levels[JAW]
    assert Running(PULSED, ArbiterState(pulsed={JAW: True})).rules.levels[JAW]


def test_a_pulse_that_was_under_way_is_ended_and_tells_the_level() -> None:
    for coil, level in ((JAW, True), (BACK, False)):
        arbiter = Running(PULSED, ArbiterState(pulsed={JAW: not level}), **{coil: True})
        assert arbiter.rules.levels[JAW] is level
        assert arbiter.wires.written == [(100 * MS, coil, False)], (
            "a whole pulse from now: it had hardly begun"
        )


def test_the_death_of_a_program_pulses_the_way_back() -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: True}))
    arbiter.lives = False
    arbiter.to(10 * S)
    assert [(line, level) for _, line, level in arbiter.wires.written] == [
        (JAW, False),
        (BACK, True),
        (BACK, False),
    ]


def test_an_arbiter_that_ends_leaves_no_coil_active() -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    assert arbiter.rules.pulses
    arbiter.rules.end_pulses()
    assert not any(arbiter.wires.state.values())
    assert not arbiter.rules.pulses
    assert arbiter.rules.state.pulsed == {}, "of a pulse that was cut short nobody knows what it has moved"


def test_a_pulse_that_cannot_be_ended_is_tried_again() -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: False}))
    arbiter.set(jaw=True)
    arbiter.wires.error = WireError("the chip is gone.")
    arbiter.to(1 * S + 350 * MS)
    assert arbiter.wires.state[JAW]
    arbiter.wires.error = None
    arbiter.to(1 * S + 500 * MS)
    assert not arbiter.wires.state[JAW]


def test_an_activation_that_fails_half_way_counts_and_its_pulse_ends() -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: False}))

    def half(levels: dict[str, bool]) -> None:
        arbiter.wires.state.update(levels)
        if True in levels.values():
            raise WireError("another chip is gone.")

    whole, arbiter.wires.set = arbiter.wires.set, half
    with pytest.raises(WireError):
        arbiter.set(jaw=True)
    arbiter.wires.set = whole
    assert arbiter.rules.levels[JAW]
    arbiter.to(2 * S)
    assert not arbiter.wires.state[JAW], "the pulse is over"


def test_one_line_that_fails_keeps_no_other_coil_active() -> None:
    both = Policy((JAW, CUP), opposites={JAW: SecondCoil(BACK, 100 * MS), CUP: SecondCoil("off", 100 * MS)})
    wires = Wires(off=False)
    wires.request = lambda names: dict(wires.state)  # type: ignore[method-assign, assignment]
    rules = LineArbiter(wires, both, 0, ArbiterState(pulsed={JAW: False, CUP: False}))
    session = rules.hello("grip", TOKEN, (JAW, CUP), (), 0)
    rules.write(session, {JAW: True, CUP: True}, None, 100 * MS)
    whole = wires.set

    def dead(levels: dict[str, bool]) -> None:
        if JAW in levels:
            raise WireError("its chip is gone.")
        whole(levels)

    wires.set = dead  # type: ignore[method-assign]
    rules.advance(250 * MS)
    assert (wires.state[JAW], wires.state[CUP]) == (True, False)
    wires.set = whole  # type: ignore[method-assign]
    rules.advance(400 * MS)
    assert not wires.state[JAW]


def test_a_journal_that_may_lag_behind_is_believed_where_it_says_active() -> None:
    said = {JAW: False, CUP: True}
    assert recall(None, JournalEntry({}, clean=True, boot="one", pulsed=said)).pulsed == said
    assert recall(None, JournalEntry({}, clean=False, boot="one", pulsed=said)).pulsed == {CUP: True}
    doubtful = ArbiterState(doubt="the session record is damaged")
    assert recall(doubtful, JournalEntry({}, clean=True, boot="one", pulsed=said)).pulsed == {CUP: True}


def test_the_levels_survive_the_arbiter_and_the_power(tmp_path: Path) -> None:
    arbiter = Running(PULSED, ArbiterState(pulsed={JAW: False}))
    assert read_arbiter_state(arbiter.rules.state.as_json()).pulsed == {JAW: False}
    journal = Journal(FileStorage(tmp_path / "journal", durable=True), "boot", lambda: 0)
    journal.keep({}, {JAW: False}, clean=True)
    journal.write_next()
    journal.close()
    entry = Journal(FileStorage(tmp_path / "journal", durable=True), "next", lambda: 0).read()
    assert recall(None, entry).pulsed == {JAW: False}
    assert recall(None, JournalEntry({}, doubt="its journal is damaged")).pulsed == {}


class NoDisk(FileStorage):
    """Can be read, not written."""

    def write(self, at: int, data: bytes) -> None:
        raise OSError(5, "Input/output error")


@pytest.mark.parametrize(("storage", "believed"), [(FileStorage, {JAW: False}), (NoDisk, {})])
def test_inactive_is_believed_once_before_anything_else_is_pulsed(
    tmp_path: Path, storage: type[FileStorage], believed: dict[str, bool]
) -> None:
    """An arbiter ended in order, the next one pulses, and the power goes before its disk has heard of it."""
    first = Journal(FileStorage(tmp_path / "journal", durable=True), "boot", lambda: 0)
    first.keep({}, {JAW: False}, clean=True)
    first.write_next()
    first.close()
    second = Journal(storage(tmp_path / "journal", durable=True), "next", lambda: 0)
    assert recall(None, second.begin(second.read())).pulsed == believed
    second.close()
    if believed:
        third = Journal(FileStorage(tmp_path / "journal", durable=True), "last", lambda: 0)
        assert recall(None, third.read()).pulsed == {}


def test_a_second_coil_has_a_line_of_its_own() -> None:
    with pytest.raises(UsageError):
        Policy((JAW, CUP), opposites={JAW: SecondCoil(CUP)})
