"""Outputs that somebody else writes: what the rules make of what nobody knows, in virtual time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import pytest

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.rules._policy import Exclusion, Need
from end_effector_hal.arbiter.rules._session import ArbiterState, SessionRecord, read_arbiter_state
from end_effector_hal.errors import LineRefusedError, WireError
from end_effector_hal.vocabulary import LastWill, LastWillStep
from end_effector_hal.wires.lines import ComposedLines, LineHandover, RemoteLines
from tests.support.keeping import MS, TOKEN, S

UNLOCK, FINGERS = "unlock", "modbus:9/0x03E8"
POLICY = Policy((UNLOCK, FINGERS), exclusions=[(UNLOCK, FINGERS)])


class Board:
    """Lines that are what was written."""

    def __init__(self) -> None:
        self.state: dict[str, bool] = {}

    def request(self, names: list[str]) -> dict[str, bool]:
        self.state = dict.fromkeys(names, False)
        return self.levels()

    def levels(self) -> dict[str, bool]:
        return dict(self.state)

    def set(self, levels: dict[str, bool]) -> None:
        assert levels.keys() <= self.state.keys()
        self.state |= levels

    def close(self) -> None:
        self.state = {}


class Far(Board):
    """Registers of which ``known`` says what anybody knows."""

    def __init__(self, known: bool | None) -> None:
        super().__init__()
        self.known, self.trouble, self.written = known, "", list[dict[str, bool]]()
        self.under_way, self.withdrawn, self.acknowledged = False, list[str](), 0
        self.prepared, self.given = list[str](), dict[str, int]()

    def request(self, names: list[str]) -> dict[str, bool]:
        assert names == [FINGERS]
        return self.levels()

    def levels(self) -> dict[str, bool]:
        return {} if self.known is None else {FINGERS: self.known}

    def set(self, levels: dict[str, bool]) -> None:
        self.written.append(levels)
        self.known = None

    def unsure(self) -> frozenset[str]:
        return frozenset() if self.known is not None else frozenset((FINGERS,))

    def owed(self) -> frozenset[str]:
        owed = self.known is None and bool(self.written) and not self.written[-1][FINGERS]
        return frozenset((FINGERS,)) if owed else frozenset()

    def activating(self) -> frozenset[str]:
        return frozenset((FINGERS,)) if self.under_way else frozenset()

    def acknowledge(self) -> None:
        self.acknowledged += 1

    def withdraw(self, lines: Iterable[str], why: str) -> None:
        self.withdrawn += [why for line in lines if line == FINGERS]

    def prepare(
        self, lines: Iterable[str], values: Mapping[str, tuple[int, ...]], given: Mapping[str, int]
    ) -> None:
        self.prepared += list(lines)
        self.given |= given

    def troubles(self) -> dict[str, str]:
        return {FINGERS: self.trouble} if self.trouble else {}

    def filenos(self) -> list[int]:
        return []

    def heard(self) -> None:
        pass


def arbiter(far: Far, state: ArbiterState | None = None, at: int = 0) -> LineArbiter:
    lines = ComposedLines(Board(), {FINGERS: far})
    assert isinstance(lines, RemoteLines)
    assert isinstance(lines, LineHandover)
    return LineArbiter(lines, POLICY, at, state)


def test_what_nobody_knows_at_a_start_counts_as_active_until_somebody_knows() -> None:
    far = Far(None)
    rules = arbiter(far)
    assert rules.levels == {UNLOCK: False, FINGERS: True}
    assert rules.read_levels() == {UNLOCK: False}  # the sensors decide
    far.known = False
    assert rules.read_levels() == rules.levels == {UNLOCK: False, FINGERS: False}
    assert far.written == []


def test_what_nobody_knows_at_a_start_was_not_changed_by_anybody() -> None:
    record = SessionRecord("grip", TOKEN, (FINGERS,), (), ended=False)
    state = ArbiterState(clients=(record,), clean=False, levels={UNLOCK: False, FINGERS: False})
    assert not arbiter(Far(None), state).predicates.faults
    assert arbiter(Far(True), state).predicates.faults  # that one was


def released(far: Far) -> LineArbiter:
    """The device has not acknowledged a release."""
    rules = arbiter(far)
    rules.write(rules.hello("grip", TOKEN, (FINGERS,), (), 0), {FINGERS: False}, None, 100 * MS)
    assert far.written == [{FINGERS: False}]
    return rules


def test_a_line_that_was_last_inactive_is_inactive_while_its_level_is_unknown() -> None:
    """Or a program would adopt it as active, because its sensors still show a part, and activate it (IL-11)."""
    far = Far(True)
    rules = released(far)
    assert rules.read_levels() == {UNLOCK: False, FINGERS: False}
    assert rules.may_be_active == [FINGERS], "an unlock is refused, and another description"
    far.known = True  # another program has written it, or its device was restarted
    assert rules.read_levels() == {UNLOCK: False, FINGERS: True}


def test_an_activation_that_is_not_acknowledged_is_unknown() -> None:
    far = Far(False)
    rules = arbiter(far)
    rules.write(rules.hello("grip", TOKEN, (FINGERS,), (), 0), {FINGERS: True}, None, 100 * MS)
    assert rules.read_levels() == {UNLOCK: False}
    assert rules.state.owed == {}


def test_an_activation_that_failed_half_way_is_unknown() -> None:
    def fails(_: dict[str, bool]) -> None:
        raise WireError("the chip does not answer.")

    far, board = Far(False), Board()
    board.set = fails  # type: ignore[method-assign]
    rules = LineArbiter(ComposedLines(board, {FINGERS: far}), Policy((UNLOCK, FINGERS)), 0)
    grip = rules.hello("grip", TOKEN, (FINGERS, UNLOCK), (), 0)
    with pytest.raises(WireError):
        rules.write(grip, {FINGERS: True, UNLOCK: True}, None, 100 * MS)
    assert far.written == [{FINGERS: True}]
    assert FINGERS not in rules.read_levels()


@pytest.mark.parametrize("known", [None, True])
def test_the_next_arbiter_writes_a_release_again_that_no_device_has_acknowledged(known: bool | None) -> None:
    state = read_arbiter_state(released(Far(True)).state.as_json())
    assert state.owed == {FINGERS: 100 * MS}
    far = Far(known)
    rules = arbiter(far, state, at=300 * MS)
    assert far.written == [{FINGERS: False}]
    assert far.given == {FINGERS: 100 * MS}
    assert rules.read_levels() == {UNLOCK: False, FINGERS: False}
    rules.written(400 * MS)
    assert rules.state.owed == {FINGERS: 100 * MS}, "the arbiter after this one keeps the intervals, too"
    assert not rules.predicates.faults
    far.known = False
    assert rules.state.owed == {}


def test_the_next_arbiter_does_not_release_in_doubt_or_what_is_released() -> None:
    state = released(Far(True)).state
    obeyed, doubted = Far(False), Far(None)
    arbiter(obeyed, state)
    rules = arbiter(doubted, replace(state, doubt="it is torn"))
    assert obeyed.written == doubted.written == []
    assert rules.read_levels() == {UNLOCK: False}
    assert rules.levels[FINGERS]


def test_no_unlock_before_a_release_is_acknowledged() -> None:
    far = Far(True)
    rules = arbiter(far)
    hal = rules.hello("hal", TOKEN, (FINGERS, UNLOCK), (), 0)
    with pytest.raises(LineRefusedError, match="IL-01: unlock is not activated while"):
        rules.write(hal, {FINGERS: False, UNLOCK: True}, None, 50 * MS)
    rules.write(hal, {FINGERS: False}, None, 100 * MS)
    assert far.written == [{FINGERS: False}]
    with pytest.raises(LineRefusedError, match="IL-01: unlock is not activated while"):
        rules.write(hal, {UNLOCK: True}, None, 200 * MS)
    far.known = False
    rules.write(hal, {UNLOCK: True}, None, 300 * MS)
    assert rules.levels[UNLOCK]


def test_trouble_is_a_latched_fault_that_a_reset_clears_when_it_is_over() -> None:
    far = Far(True)
    rules = released(far)
    far.trouble = "is to be deactivated, and no device acknowledges it"
    rules.advance(1 * S)
    told = f"{FINGERS} {far.trouble}."
    assert rules.predicates.faults == {f"output {FINGERS}": told}
    with pytest.raises(LineRefusedError, match="no device acknowledges it: this fault stays"):
        rules.reset(2 * S)
    far.trouble = ""
    rules.advance(3 * S)
    assert rules.predicates.faults
    rules.reset(4 * S)
    assert not rules.predicates.faults


def test_trouble_is_over_when_its_line_was_activated_again_and_its_device_confirms_that() -> None:
    far = Far(False)
    rules = arbiter(far)
    grip = rules.hello("grip", TOKEN, (FINGERS,), (), 0)
    rules.write(grip, {FINGERS: True}, None, 500 * MS)
    far.known, far.trouble = None, "is not activated any more: its device was restarted, or has a fault"
    rules.advance(1 * S)
    told = dict(rules.predicates.faults)
    assert list(told) == [f"output {FINGERS}"]
    far.known, far.trouble = True, ""  # by itself: what was held may be lost
    rules.advance(2 * S)
    rules.write(grip, {FINGERS: False}, None, 3 * S)
    far.known = False
    rules.advance(4 * S)
    rules.write(grip, {FINGERS: True}, None, 5 * S)
    rules.advance(6 * S)
    assert rules.predicates.faults == told, "its device has not confirmed it yet"
    far.known = True
    rules.advance(7 * S)
    assert not rules.predicates.faults


def test_that_an_output_cannot_be_read_is_over_when_it_is_read_again() -> None:
    """Nobody has commanded it; the fault may be that of an earlier arbiter."""
    far = Far(None)
    far.trouble = "is not known: its bus cannot be read"
    rules = arbiter(far)
    rules.advance(1 * S)
    with pytest.raises(LineRefusedError, match="cannot be read: this fault stays"):
        rules.reset(2 * S)
    rules = arbiter(far, rules.state, 3 * S)
    rules.advance(4 * S)
    assert rules.predicates.faults == {f"unread {FINGERS}": f"{FINGERS} {far.trouble}."}
    far.known, far.trouble = False, ""
    rules.advance(5 * S)
    assert not rules.predicates.faults


def test_trouble_of_an_activation_stays_until_one_succeeds() -> None:
    far = Far(False)
    rules = arbiter(far)
    grip = rules.hello("grip", TOKEN, (FINGERS,), (), 0)
    rules.write(grip, {FINGERS: True}, None, 1 * S)
    far.trouble = "was not activated: the device is not ready"
    rules.advance(2 * S)
    far.trouble, far.known = "", True  # late, and nobody has asked for it again
    rules.advance(3 * S)
    assert rules.predicates.faults


def test_a_reset_has_the_devices_clear_their_faults() -> None:
    far = Far(False)
    rules = arbiter(far)
    rules.reset(0)
    assert far.acknowledged == 1


def test_an_activation_on_its_way_ends_with_its_program() -> None:
    far = Far(False)
    rules = arbiter(far)
    session = rules.hello("grip", TOKEN, (FINGERS,), (), 0)
    rules.write(session, {FINGERS: True}, None, 100 * MS)
    assert far.withdrawn == []
    rules.declare_dead(session, "it was killed", 200 * MS)
    assert far.withdrawn == ["its program has died"]


def test_an_activation_on_its_way_ends_where_an_interlock_objects_by_now() -> None:
    far = Far(False)
    policy = Policy(
        (FINGERS,), needs={FINGERS: [Need("estop_ok", "IL-13", "the e-stop is closed", "the e-stop is open")]}
    )
    rules = LineArbiter(ComposedLines(Board(), {FINGERS: far}), policy, 0)
    session = rules.hello("grip", TOKEN, (FINGERS,), (), 0)
    rules.predicates.update({"estop_ok": True}, 100 * MS, 100 * MS)
    rules.write(session, {FINGERS: True}, None, 100 * MS)
    far.under_way = True
    rules.predicates.update({"estop_ok": True}, 190 * MS, 190 * MS)
    rules.advance(200 * MS)
    assert far.withdrawn == []
    rules.predicates.update({"estop_ok": False}, 210 * MS, 210 * MS)
    rules.advance(210 * MS)
    (why,) = far.withdrawn
    assert why.startswith("IL-13: ")


def test_a_pause_counts_from_when_the_device_has_switched() -> None:
    far = Far(True)
    policy = Policy((UNLOCK, FINGERS), exclusions=[Exclusion(UNLOCK, FINGERS, "IL-08", "IL-08", 50 * MS)])
    rules = LineArbiter(ComposedLines(Board(), {FINGERS: far}), policy, 0)
    grip = rules.hello("grip", TOKEN, (FINGERS,), (), 0)
    blow = rules.hello("blow", TOKEN, (UNLOCK,), (), 0)
    rules.write(grip, {FINGERS: False}, None, 100 * MS)
    far.known = False  # 300 ms later
    rules.advance(400 * MS)
    with pytest.raises(LineRefusedError, match="within 50 ms after"):
        rules.write(blow, {UNLOCK: True}, None, 401 * MS)
    rules.write(blow, {UNLOCK: True}, None, 451 * MS)


LIMITED = replace(POLICY, max_active_us={FINGERS: 3 * S}, roles={})


def test_the_longest_time_is_counted_from_the_command_whatever_the_device_reports() -> None:
    far = Far(False)
    rules = LineArbiter(ComposedLines(Board(), {FINGERS: far}), LIMITED, 0)
    session = rules.hello("hal", TOKEN, (FINGERS,), (), 0)
    rules.write(session, {FINGERS: True}, None, 100 * MS)
    for at in range(200 * MS, 3 * S, 100 * MS):  # it is acknowledged, and doubted, again and again
        far.known = None if far.known else True
        rules.renew(session, at)
        rules.advance(at)
    assert far.written == [{FINGERS: True}]
    rules.advance(3 * S + 100 * MS)
    assert far.written[-1] == {FINGERS: False}
    (why,) = rules.predicates.faults.values()
    assert why.startswith(f"IL-03: {FINGERS} was active for its longest time and is being deactivated")


CUP, BLOW = "cup", "blow"
WILL = (LastWillStep(BLOW), LastWillStep(FINGERS), LastWillStep(CUP, after_us=2 * S))


def dies_while_released(will: LastWill) -> tuple[LineArbiter, Far]:
    """The fingers owe their release, the cup holds, and the blow-off blows; their program dies at 1 s."""
    far, policy = (
        Far(True),
        Policy((BLOW, CUP, FINGERS), max_active_us={BLOW: 9 * S}, release_us={FINGERS: 2 * S}),
    )
    rules = LineArbiter(ComposedLines(Board(), {FINGERS: far}), policy, 0)
    session = rules.hello("hal", TOKEN, (BLOW, CUP, FINGERS), (), 0)
    rules.write(session, {BLOW: True, CUP: True}, None, 500 * MS)
    rules.write(session, {FINGERS: False}, will, 900 * MS)
    rules.declare_dead(session, "killed", 1 * S)
    return rules, far


def test_a_blow_off_ends_at_once_and_a_last_will_waits_once_for_a_release() -> None:
    rules, _ = dies_while_released(WILL)
    assert rules.levels == {BLOW: False, CUP: True, FINGERS: False}
    rules.advance(3 * S - 1)
    assert rules.levels[CUP]
    rules.advance(3 * S)
    assert not rules.levels[CUP]


def test_a_last_will_that_waits_for_a_later_step_can_be_read_by_the_next_arbiter() -> None:
    """The cup waits for the release of the fingers, of which the will itself has a step before."""
    will = (LastWillStep(CUP), LastWillStep(FINGERS, after_us=1 * S))
    rules, _ = dies_while_released(will)
    (client,) = read_arbiter_state(rules.state.as_json()).clients
    assert [(step.line, step.after_us) for step in client.will] == [(FINGERS, 1 * S), (CUP, 2 * S)]
