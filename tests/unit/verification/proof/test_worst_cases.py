"""The computed worst cases equal those derived by hand (docs/explanation/verification.md), whatever the tool."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification.proof import WorstCase, prove
from tests.support.nightly import first_of
from timed_automata import load_network

pytestmark = pytest.mark.thinned  # long


@dataclass(frozen=True)
class Tool:
    """Times in ms, one per step."""

    attempts: tuple[int, ...] = (3, 3, 3)
    confirm: tuple[int, ...] = (5000, 5000, 5000)
    reset: tuple[int, ...] = (1000, 1000, 1000)
    gone: tuple[int, ...] = (2000, 2000, 2000)
    late: int = 50
    release_order: tuple[int, ...] = (2, 1, 0)

    @property
    def decided(self) -> int:
        """Every attempt but the last times out and is followed by a pause; each deadline is late by D."""
        steps = zip(self.attempts, self.confirm, self.reset, strict=True)
        return sum(a * (t + self.late) + (a - 1) * (r + self.late) for a, t, r in steps)

    @property
    def release(self) -> int:
        """No feedback goes away in time."""
        return sum(gone + self.late for gone in self.gone)

    @property
    def over(self) -> int:
        """The last attempt of the last step times out, then everything is unwound."""
        return self.decided + self.release

    @property
    def constants(self) -> dict:
        return {
            "N": len(self.attempts),
            "USES": [[True] * len(self.attempts)],
            "ATTEMPTS": [list(self.attempts)],
            "T_CONFIRM": [list(self.confirm)],
            "T_RESET": list(self.reset),
            "T_GONE": list(self.gone),
            "RELEASE_ORDER": list(self.release_order),
            **{name: [0] * len(self.attempts) for name in ("T_BLOW", "T_GAP", "IL_08_GAP")},
            "UNTIL_GONE": [False] * len(self.attempts),
            "D": self.late,
            **{
                f"{ending}_KEEPS": [False] * len(self.attempts)
                for ending in ("CANCEL", "TIMEOUT", "ABORT", "DEATH")
            },
            **{f"{ending}_KEEPS": [True] * len(self.attempts) for ending in ("LOSS", "START", "HELD_DEATH")},
            "GRIP_BOUND": self.over,
            "RELEASE_BOUND": self.release,
            "CANCEL_BOUND": self.release,
        }


PAPER = Tool()
ONE = Tool((3,), (5000,), (1000,), (2000,), 50, (0,))
TWO = Tool((2, 3), (1500, 800), (300, 1200), (250, 4000), 20, (0, 1))


def proved(constants: dict):
    description = load(profile_path())
    return prove(load_network(description.automata_path, model_constants(description) | constants))


def test_the_formulas_give_the_numbers_of_the_contract():
    """51 s and 57 s plus a D per deadline; 6 s plus three."""
    assert PAPER.decided == 51_000 + 15 * 50
    assert PAPER.over == 57_000 + 18 * 50
    assert PAPER.release == 6_000 + 3 * 50


@pytest.mark.parametrize(
    "tool",
    [
        pytest.param(ONE, id="one step"),
        pytest.param(
            replace(ONE, attempts=(1,), late=7), id="one step, one attempt", marks=pytest.mark.nightly
        ),
        pytest.param(
            TWO, id="two steps, other times, released in the order of the grip", marks=pytest.mark.nightly
        ),
        pytest.param(PAPER, id="the paper's", marks=pytest.mark.nightly),
        pytest.param(
            Tool((2, 1, 4), (700, 4000, 90), (2000, 10, 400), (100, 60, 2500), 5, (1, 2, 0)),
            id="three steps, all times different",
        ),
    ],
)
def test_computed_equals_derived(tool):
    proof = proved(tool.constants)
    assert [finding.id for finding in proof.findings if not finding.holds] == []
    bounds = proof.bounds
    assert bounds["grip_decided_s"] == WorstCase(tool.decided, tool.over)
    assert bounds["grip_s"] == WorstCase(tool.over, tool.over)
    assert bounds["release_s"] == WorstCase(tool.release, tool.release)
    assert bounds["cancel_s"] == WorstCase(tool.release, tool.release)


@pytest.mark.parametrize(
    "case",
    first_of([("GRIP_BOUND", ONE.over), ("RELEASE_BOUND", ONE.release), ("CANCEL_BOUND", ONE.release)]),
)
def test_a_bound_one_millisecond_below_does_not_hold(case):
    name, worst = case
    bound, failing = {name: worst - 1}, name.removesuffix("_BOUND").lower()
    proof = proved(ONE.constants | bound)
    (finding,) = [finding for finding in proof.findings if not finding.holds]
    (declared,) = bound.values()
    assert finding.id == failing
    assert finding.worst == WorstCase(declared + 1, declared)
    assert finding.trace is not None
    assert f"up to {declared + 1} ms" in finding.remark


def test_the_bounds_are_those_of_the_description():
    description = load(profile_path())
    constants = model_constants(description)
    declared = {name: constants[f"{name}_BOUND"] for name in ("GRIP", "RELEASE", "CANCEL")}
    assert declared == {"GRIP": 58_000, "RELEASE": 6_200, "CANCEL": 6_200}
