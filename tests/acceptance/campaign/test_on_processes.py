"""A case of a campaign on real processes ends as in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_lab.trials import case_from_words, play_case
from tests.support.on_processes import play_on_processes

pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]
SHIPPED = load(profile_path())


@pytest.mark.parametrize(
    "words",
    [
        "grip; wait 3; kill hal; wait 1; start hal; wait 8; drop",
        pytest.param(
            "scenario never-confirms:cylinder; wait 0.2; grip; wait 3; kill all; wait 1; start all",
            marks=pytest.mark.thinned,
        ),
    ],
)
def test_it_ends_the_same(words: str, tmp_path: Path) -> None:
    case = case_from_words(words, SHIPPED)
    real = play_on_processes(SHIPPED, case, tmp_path)
    assert real == play_case(SHIPPED, case).end
    assert real.moved
