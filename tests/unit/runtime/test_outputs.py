"""What is asked of the line arbiter for which statuses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ArbiterError, LineRefusedError, ReportedError
from end_effector_hal.runtime.outputs import RETRY_US, Maintenance, OutputMapping, Outputs
from end_effector_hal.vocabulary import NO_PART, Command, EndEffectorState, LastWillStep, WrittenPart

A, B, TOP, UNLOCK = "SODIMM_208", "SODIMM_210", "SODIMM_212", "SODIMM_206"
UNWIND_A, UNWIND = (LastWillStep(A),), (LastWillStep(B), LastWillStep(A))


class Lines:
    """Remembers what was asked of it, and what was waited for."""

    def __init__(self) -> None:
        self.asked: list[tuple[dict[str, bool], tuple[LastWillStep, ...]]] = []
        self.waited = 0
        self.error: ReportedError | None = None
        self.active: dict[str, bool] = {}
        self.dead = False
        self.delay_us = 0

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        self.asked.append((dict(levels), tuple(will)))
        return self._wait

    def _wait(self) -> int:
        self.waited += 1
        if self.error:
            raise self.error
        self.active |= self.asked[-1][0]
        return self.delay_us

    def levels(self) -> Mapping[str, bool]:
        return self.active

    def recorded_part(self) -> str:
        return ""

    def declared_dead(self) -> bool:
        return self.dead

    def close(self, will: Sequence[LastWillStep]) -> None:
        del will


def status(
    at: int, a: bool, b: bool, *, held: bool = False, attempt: int = 0, unlock: bool = False
) -> Status:
    return Status(
        at=at, ee=0, command=0, actuators=(), outputs=(a, b), evidence=(), held=held, attempt=attempt,
        adopted=True, unlock_output=unlock,
    )  # fmt: skip


class TwoLines:
    """Two lines of actuators and the unlock line, and the unwinding of the two as a will."""

    unlock_line = UNLOCK

    def levels(self, status: Status) -> dict[str, bool]:
        return dict(zip((A, B, UNLOCK), (*status.outputs, status.unlock_output), strict=True))

    def grips(self, status: Status, changes: Mapping[str, bool]) -> WrittenPart:
        return NO_PART

    def dropped(self, status: Status) -> str:
        return ""

    def last_will(self, status: Status, on: str = "process_death") -> tuple[LastWillStep, ...]:
        del on
        return () if status.held else UNWIND if status.outputs[1] else UNWIND_A if status.outputs[0] else ()

    def gripping(self, _: Status) -> bool:
        return False


def outputs_of(lines: Lines) -> Outputs:
    return Outputs(lines, TwoLines())


def written(lines: Lines, *statuses: Status) -> list[tuple[dict[str, bool], tuple[LastWillStep, ...]]]:
    outputs, rest = outputs_of(lines), list[Status](statuses)
    while rest:
        rest = list(outputs.begin(rest))
        outputs.finish()
    return lines.asked


def test_what_is_begun_is_not_waited_for() -> None:
    lines = Lines()
    outputs = outputs_of(lines)
    rest = outputs.begin([status(1, True, False), status(1, True, True)])
    assert lines.asked == [({A: True, B: False, UNLOCK: False}, UNWIND_A)]
    assert (lines.waited, [each.outputs for each in rest]) == (0, [(True, True)])
    outputs.finish()
    assert lines.waited == 1


@pytest.mark.parametrize(("delay_us", "settles_at"), [(0, None), (50_000, 50_001), (10**12, 1 + RETRY_US)])
def test_it_knows_how_long_a_write_waits_and_asks_again(delay_us: int, settles_at: int | None) -> None:
    lines = Lines()
    outputs, lines.delay_us = outputs_of(lines), delay_us
    outputs.begin([status(1, True, False)])
    outputs.finish()
    assert outputs.settles_at == settles_at
    lines.delay_us = 0
    outputs.retry(status(60_000, True, False), 60_000)
    assert lines.asked[-1] == ({}, UNWIND_A)
    assert outputs.settles_at is None


def test_what_changes_neither_line_nor_will_is_not_written() -> None:
    assert len(written(Lines(), status(1, True, False), status(2, True, False))) == 1


def test_a_drop_is_one_write_the_will_goes_with_the_line() -> None:
    held = status(1, True, True, held=True)
    both = written(Lines(), held, status(2, True, True), status(2, True, False))
    assert both == [({A: True, B: True, UNLOCK: False}, ()), ({B: False}, UNWIND_A)]


def test_a_will_is_written_by_itself_where_the_line_follows_later_or_is_activated() -> None:
    held = status(1, True, False, held=True)
    later = written(Lines(), held, status(2, True, False), status(3, False, False))
    assert later[1:] == [({}, UNWIND_A), ({A: False}, ())]
    activated = written(Lines(), held, status(2, True, False), status(2, True, True))
    assert activated[1:] == [({}, UNWIND_A), ({B: True}, UNWIND)]


def test_after_a_refusal_the_same_reaction_activates_nothing_more() -> None:
    lines = Lines()
    lines.error = LineRefusedError("IL-13: no.")
    outputs = outputs_of(lines)
    chain = [status(1, True, False), status(1, True, True), status(1, False, True)]
    rest = outputs.begin(chain)
    outputs.finish()
    lines.error = None
    outputs.complete(rest)
    assert lines.active == {A: False, B: False, UNLOCK: False}
    outputs.objected.clear()  # the automata have been told
    outputs.complete([status(2, True, True)])
    assert lines.asked[-1][0] == {A: True}  # B was wanted before: it is not activated later by itself (IL-11)


@pytest.mark.parametrize("unlock", [False, True])
def test_a_refusal_is_known_of_its_line_once_it_was_waited_for_and_until_the_next_activation(
    unlock: bool,
) -> None:
    lines = Lines()
    lines.error = LineRefusedError("IL-05: no.")
    outputs = outputs_of(lines)
    outputs.begin([status(1, not unlock, False, unlock=unlock)])
    assert not outputs.objected
    outputs.finish()
    assert outputs.objected == {unlock}
    assert outputs.refused == {unlock: "IL-05: no.", not unlock: ""}
    outputs.objected.clear()
    lines.error = None
    outputs.complete([status(2, False, False), status(3, unlock, False, unlock=not unlock)])
    assert outputs.refused == {unlock: "IL-05: no.", not unlock: ""}, "the other line was accepted"
    outputs.complete([status(4, False, False), status(5, not unlock, False, unlock=unlock)])
    assert outputs.refused == {False: "", True: ""}


def activation_that_found_no_arbiter(lines: Lines) -> Outputs:
    outputs = outputs_of(lines)
    for each in (status(1, True, False, attempt=1), status(2, True, True, attempt=1)):
        lines.error = ArbiterError("the line arbiter was lost.") if each.outputs[1] else None
        outputs.begin([each])
        outputs.finish()
    assert outputs.lost
    lines.error = None
    assert outputs.agree(3)
    lines.asked.clear()
    return outputs


def test_an_activation_that_was_lost_with_the_arbiter_comes_with_the_next_attempt() -> None:
    """Of an actuator that stays active between its attempts (`timeout: hold`), whose output does not change."""
    lines = Lines()
    outputs = activation_that_found_no_arbiter(lines)
    outputs.begin([status(4, True, True, attempt=1)])
    outputs.finish()
    assert all(not levels for levels, _ in lines.asked), "not by itself (IL-11)"
    for at in (5, 6):
        outputs.begin([status(at, True, True, attempt=2)])
        outputs.finish()
    assert [levels for levels, _ in lines.asked if levels] == [{B: True}]
    outputs.begin([status(7, True, True, attempt=3)])
    outputs.finish()
    assert [levels for levels, _ in lines.asked if levels] == [{B: True}], "it was heard"


def test_what_was_lost_and_is_not_wanted_any_more_does_not_come() -> None:
    lines = Lines()
    outputs = activation_that_found_no_arbiter(lines)
    for at, active, attempt in ((4, False, 1), (5, False, 2)):
        outputs.begin([status(at, True, active, attempt=attempt)])
        outputs.finish()
    assert not any(levels.get(B) for levels, _ in lines.asked)


@pytest.mark.parametrize(
    ("found", "dead", "why"),
    [
        ({A: True, B: False}, False, ""),
        (
            {A: False, B: False},
            False,
            f"While the line arbiter was lost {A} changed, which this program had not commanded; ",
        ),
        ({B: False}, False, f"After the line arbiter was lost the level of {A} was unknown; "),
        ({A: False, B: False}, True, "The line arbiter declared this program dead and executed its last will; "),
        ({B: False}, True, "The line arbiter declared this program dead and executed its last will; "),
    ],
)  # fmt: skip
def test_why_the_lines_do_not_agree_is_what_was_found(found: dict[str, bool], dead: bool, why: str) -> None:
    """An arbiter that was restarted has declared nobody dead; a register that nothing reads back is unknown then."""
    lines = Lines()
    outputs = outputs_of(lines)
    outputs.begin([status(1, True, False, attempt=1)])
    outputs.finish()
    lines.active, lines.dead = {UNLOCK: False, **found}, dead
    assert outputs.agree(3) is (not why)
    assert outputs.disagreement == (f"{why}the program has restarted." if why else "")


def test_the_tool_changer_is_locked_first_also_while_maintenance_drives_lines() -> None:
    description = load(profile_path())
    maintenance = Maintenance(description)
    mapping = OutputMapping(description, maintenance)
    releasing = Status(
        at=0, ee=EndEffectorState.RELEASING, command=Command.RELEASE, actuators=(), outputs=(True, True, False),
        evidence=(), unlock_output=True,
    )  # fmt: skip

    def lines(will: Sequence[LastWillStep]) -> list[str]:
        assert not any(step.level for step in will)
        return [step.line for step in will]

    assert lines(mapping.last_will(releasing)) == [UNLOCK, B, A]
    assert lines(mapping.maintenance_will(releasing, TOP, active=True)) == [UNLOCK, TOP]
    maintenance.drove(TOP, True, 0)
    for ending in ("process_death", "sigterm"):
        assert lines(mapping.last_will(releasing, ending)) == [UNLOCK, TOP]
    assert lines(mapping.maintenance_will(releasing, A, active=True)) == [UNLOCK, TOP, A]
    assert lines(mapping.maintenance_will(releasing, TOP, active=False)) == [UNLOCK]
    locked = replace(releasing, unlock_output=False)
    assert lines(mapping.last_will(locked)) == [TOP]
