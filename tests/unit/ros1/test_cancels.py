"""Cancels that overtake their goals: whose clock counts, for how long, and how many are remembered."""

from __future__ import annotations

import pytest

from end_effector_hal.ros1._actions import OVERTAKES_US, REMEMBERED, Cancels

S = 1_000_000_000  # ns
T = 1_700_000_000 * S
NOW = 10_000_000


@pytest.fixture
def cancels() -> Cancels:
    return Cancels()


def test_an_id_counts_however_late_its_goal_comes(cancels: Cancels) -> None:
    cancels.add("a", 0, NOW)
    assert cancels.cover("a", T, NOW + 100 * OVERTAKES_US)
    assert not cancels.cover("b", T, NOW)


def test_the_newest_ids_are_remembered(cancels: Cancels) -> None:
    for number in range(REMEMBERED):
        cancels.add(str(number), 0, NOW)
    cancels.add("0", 0, NOW)
    cancels.add("one more", 0, NOW)
    assert not cancels.cover("1", T, NOW)
    assert all(cancels.cover(each, T, NOW) for each in ("0", "2", "one more"))
    assert len(cancels._ids) == REMEMBERED


def test_a_stamp_counts_for_goals_up_to_it(cancels: Cancels) -> None:
    cancels.add("", T, NOW)
    assert cancels.cover("a", T - S, NOW)
    assert cancels.cover("a", T, NOW)
    assert not cancels.cover("a", T + 1, NOW)
    assert not cancels.cover("a", 0, NOW), "a goal without a stamp is new"


def test_a_stamp_counts_for_goals_that_come_soon_whatever_their_clock(cancels: Cancels) -> None:
    cancels.add("", T, NOW)
    behind = T - 60 * S
    assert cancels.cover("a", behind, NOW + OVERTAKES_US)
    assert not cancels.cover("a", behind, NOW + OVERTAKES_US + 1)


def test_an_older_stamp_takes_nothing_back(cancels: Cancels) -> None:
    cancels.add("", T, NOW)
    cancels.add("", T - 10 * S, NOW + 1)
    assert cancels.cover("a", T, NOW + 2)
    later = NOW + 2 * OVERTAKES_US
    cancels.add("", T - 10 * S, later)
    assert not cancels.cover("a", T, later), "the first has had its time"


def test_everything_is_no_matter_of_goals_that_are_yet_to_come(cancels: Cancels) -> None:
    cancels.add("", 0, NOW)
    assert not cancels.cover("a", T, NOW)
