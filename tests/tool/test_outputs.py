"""What is asked of the line owner for which statuses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from end_effector_hal.control import Status
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.tool._outputs import Outputs
from end_effector_hal.wires import WillStep

A, B = "SODIMM_208", "SODIMM_210"
UNWIND_A, UNWIND = (WillStep(A),), (WillStep(B), WillStep(A))


class Lines:
    """Remembers what was asked of it, and what was waited for."""

    def __init__(self) -> None:
        self.asked: list[tuple[dict[str, bool], tuple[WillStep, ...]]] = []
        self.waited = 0
        self.error: LineRefusedError | None = None

    def ask(self, levels: Mapping[str, bool], will: Sequence[WillStep]) -> Callable[[], None]:
        self.asked.append((dict(levels), tuple(will)))
        return self._wait

    def _wait(self) -> None:
        self.waited += 1
        if self.error:
            raise self.error

    def levels(self) -> Mapping[str, bool]:
        return {}

    def close(self, will: Sequence[WillStep]) -> None:
        del will


def status(at: int, a: bool, b: bool, *, held: bool = False) -> Status:
    return Status(at=at, ee=0, command=0, actuators=(), outputs=(a, b), evidence=(), held=held)


def outputs_of(lines: Lines) -> Outputs:
    def will(of: Status) -> tuple[WillStep, ...]:
        return () if of.held else UNWIND if of.outputs[1] else UNWIND_A if of.outputs[0] else ()

    return Outputs(lines, lambda of: dict(zip((A, B), of.outputs, strict=True)), will)


def written(lines: Lines, *statuses: Status) -> list[tuple[dict[str, bool], tuple[WillStep, ...]]]:
    outputs, rest = outputs_of(lines), list[Status](statuses)
    while rest:
        rest = list(outputs.begin(rest))
        outputs.finish()
    return lines.asked


def test_what_is_begun_is_not_waited_for() -> None:
    lines = Lines()
    outputs = outputs_of(lines)
    rest = outputs.begin([status(1, True, False), status(1, True, True)])
    assert lines.asked == [({A: True, B: False}, UNWIND_A)]
    assert (lines.waited, [each.outputs for each in rest]) == (0, [(True, True)])
    outputs.finish()
    assert lines.waited == 1


def test_what_changes_neither_line_nor_will_is_not_written() -> None:
    assert len(written(Lines(), status(1, True, False), status(2, True, False))) == 1


def test_a_drop_is_one_write_the_will_goes_with_the_line() -> None:
    held = status(1, True, True, held=True)
    both = written(Lines(), held, status(2, True, True), status(2, True, False))
    assert both == [({A: True, B: True}, ()), ({B: False}, UNWIND_A)]


def test_a_will_is_written_by_itself_where_the_line_follows_later_or_is_activated() -> None:
    held = status(1, True, False, held=True)
    later = written(Lines(), held, status(2, True, False), status(3, False, False))
    assert later[1:] == [({}, UNWIND_A), ({A: False}, ())]
    activated = written(Lines(), held, status(2, True, False), status(2, True, True))
    assert activated[1:] == [({}, UNWIND_A), ({B: True}, UNWIND)]


def test_a_refusal_is_known_once_it_was_waited_for() -> None:
    lines = Lines()
    lines.error = LineRefusedError("IL-05: no.")
    outputs = outputs_of(lines)
    outputs.begin([status(1, True, False)])
    assert not outputs.objected
    outputs.finish()
    assert outputs.objected
    assert outputs.refused == "IL-05: no."
