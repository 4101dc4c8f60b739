"""The comparison itself, on recordings that are written here."""

from __future__ import annotations

import pytest

from end_effector_hal.recording import StatesLog, StatesRow
from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.acceptance.gpiochip.same_story import same_story

State = EndEffectorState
STORY = (
    (0.0, State.STAND_BY, (0, 0)),
    (2.0, State.GRIPPING, (0, 0)),
    (2.0, State.GRIPPING, (1, 0)),
    (2.4, State.GRIPPING, (2, 0)),
    (2.4, State.GRIPPING, (2, 1)),
    (2.9, State.GRIPPED, (2, 2)),
)


def recording(*rows: tuple[float, EndEffectorState, tuple[int, ...]]) -> StatesLog:
    return StatesLog(
        ("bottom", "top"),
        tuple(StatesRow(at, state, Command.NONE, actuators) for at, state, actuators in rows),
    )


def shifted(by_s: float, first: int) -> list[tuple[float, EndEffectorState, tuple[int, ...]]]:
    return [(at + (by_s if i >= first else 0.0), *rest) for i, (at, *rest) in enumerate(STORY)]  # type: ignore[misc]


def test_a_recording_is_the_same_story_as_itself() -> None:
    assert same_story(recording(*STORY), recording(*STORY)) == 0


def test_when_the_grip_begins_does_not_matter() -> None:
    assert same_story(recording(*STORY), recording(*shifted(7.0, 1))) == pytest.approx(0)


def test_which_row_of_a_moment_comes_first_does_not_matter() -> None:
    passed_through = (*STORY[:3], (2.4, State.GRIPPING, (2, 1)), STORY[5])
    assert same_story(recording(*STORY), recording(*passed_through)) == 0


def test_a_step_may_be_a_little_longer() -> None:
    assert same_story(recording(*STORY), recording(*shifted(0.09, 3))) == pytest.approx(0.09)


def test_a_step_that_is_too_long() -> None:
    with pytest.raises(AssertionError, match=r"stood for 0\.400 s here and for 0\.600 s there"):
        same_story(recording(*STORY), recording(*shifted(0.2, 3)))


def test_another_state() -> None:
    other = (*STORY[:5], (2.9, State.GRIP_ERROR, (2, 1)))
    with pytest.raises(AssertionError):
        same_story(recording(*STORY), recording(*other))


def test_no_grip() -> None:
    with pytest.raises(AssertionError, match="no grip was recorded"):
        same_story(recording(STORY[0]), recording(STORY[0]))
