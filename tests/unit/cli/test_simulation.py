"""What simulates a tool is found by an entry point, or asked for in one sentence."""

from __future__ import annotations

import pytest

from end_effector_hal.cli import _simulation
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import MissingExtraError
from end_effector_hal.plugins import Plugins
from end_effector_lab.demo import World


def test_the_workshop_has_it() -> None:
    assert _simulation._SIMULATION.get(_simulation.NAME) is World


def test_without_it_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        _simulation, "_SIMULATION", Plugins("nothing.of.this", "simulation", {}, lambda it: it)
    )
    with pytest.raises(MissingExtraError) as refused, _simulation.simulated(load(profile_path())):
        pass
    assert str(refused.value) == (
        "Nothing that simulates a tool is installed. Install it: pip install 'end-effector-hal[lab]'."
    )
