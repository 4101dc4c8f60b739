"""A trace whose times jump: its replay ends, with a difference or a sentence; nothing is decided in 2038."""

from __future__ import annotations

from typing import Any

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.verification.replay import ProgramTrace, review
from tests.unit.verification.replay.conftest import edited, numbers

YEAR_2038 = 2_147_483_647_000_000
JUMPS = [YEAR_2038, 2**63 - 1, 2**80, 0, -1, -(2**63), 1.5, float("nan"), float("inf"), "now", None, 10**400]


def outcome(trace: ProgramTrace) -> str:
    """What is said of a trace, in words."""
    try:
        found = review(trace)
    except UsageError as error:
        return str(error)
    return "" if found.ok else str(found.replay.difference or found.objections[0])


@pytest.mark.parametrize(
    ("kind", "key", "jump"),
    [
        pytest.param(*place, jump, id=f"{'-'.join(place)}-{jump!r:.12}", marks=marks)
        for place in (("frame", "stamp"), ("frame", "at"), ("time", "at"), ("command", "at"))
        for number, jump in enumerate(JUMPS)
        # each jump at one place, and each place with one jump ahead, one back and one that is no number
        for marks in ([] if place[1] == "stamp" or number in (0, 4, 9) else [pytest.mark.thinned],)
    ],
)
def test_a_jump_of_a_stamp_is_found_and_ends(
    gripped: ProgramTrace, kind: str, key: str, jump: object
) -> None:
    middle = numbers(gripped, kind)[len(numbers(gripped, kind)) // 2]

    def jumps(content: dict[str, Any]) -> None:
        content[key] = jump

    said = outcome(edited(gripped, middle, jumps))
    backwards = key == "at" and type(jump) is int and jump <= 0
    assert said or backwards, "what comes late counts as coming now"
    assert "Traceback" not in said


def test_a_frame_of_2038_in_a_trace_is_refused_again(gripped: ProgramTrace) -> None:
    middle = numbers(gripped, "frame")[40]
    said = outcome(edited(gripped, middle, lambda content: content.update(stamp=YEAR_2038)))
    assert said.startswith("status: recorded nothing, replayed"), "the alarm that it was refused"
