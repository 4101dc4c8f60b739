"""The computed worst cases equal those derived by hand (docs/explanation/verification.md), whatever the tool."""

from __future__ import annotations

import random
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.verification.proof import Proof, WorstCase, prove
from tests.support.declared import declared
from tests.support.nightly import NIGHTLY, first_of
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
        pytest.param(replace(ONE, attempts=(1,), late=7), id="one step, one attempt", marks=pytest.mark.nightly),
        pytest.param(TWO, id="two steps, other times, released in the order of the grip", marks=pytest.mark.nightly),
        pytest.param(PAPER, id="the paper's", marks=pytest.mark.nightly),
        pytest.param(
            Tool((2, 1, 4), (700, 4000, 90), (2000, 10, 400), (100, 60, 2500), 5, (1, 2, 0)),
            id="three steps, all times different",
        ),
    ],
)  # fmt: skip
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


# Bounds that nobody wrote are what the steps add up to: never less than the worst case, and no more than that.


HELD = (
    "gripping: {cancel: hold}",
    "gripping: {timeout: hold}",
    "gripping: {abort: hold, process_death: hold}",
)
SEEDS = first_of(range(60 if NIGHTLY else 6), 2, 0)
SIZES = first_of((4, 1, 5, 2, 3, 6, 7, 8) if NIGHTLY else (4, 1, 5), thinned=0)


def drawn(seed: int, path: Path, *, steps: int, held: bool) -> Description:
    """A tool with times of its own for each step, in any order of release."""
    draw = random.Random(seed)
    names = [f"cup_{at}" for at in range(steps)]
    actuators = []
    for at, name in enumerate(names):
        confirm, pause, gone = (draw.choice((0.06, 0.2, 1.5, 5, 30)) for _ in range(3))
        endings = f", endings: {{{draw.choice(HELD)}}}" if held and draw.random() < 0.6 else ""
        actuators.append(
            f"  {name}: {{kind: vacuum, line: L{at}, channel: c{at}, attempts: {draw.randint(1, 4)}, "
            f"timeout_s: {confirm}, reset_s: {pause}, release_s: {gone}{endings}}}"
        )
    order = ", ".join(draw.sample(names, steps))
    path.write_text(
        f"name: tool\nlink: {{port: /dev/ttyS1}}\nsequence: [{', '.join(names)}]\nrelease_order: [{order}]\n"
        f"actuators:\n{chr(10).join(actuators)}\nbounds: {{reaction_ms: {draw.choice((1, 20, 50, 200))}}}\n",
        encoding="utf-8",
    )
    return load(path)


def worst_cases(description: Description) -> dict[str, int | None]:
    """What the model checker computes, ms, after every requirement was found to hold."""
    proof = prove(load_network(description.automata_path, model_constants(description)))
    assert [finding.id for finding in proof.findings if not finding.holds] == []
    return {key: proof.bounds[key].computed_ms for key in ("grip_s", "release_s", "cancel_s")}


def formula(description: Description) -> dict[str, int]:
    found = description.durations
    assert found.computed == ("grip_s", "release_s", "cancel_s")
    return {"grip_s": found.grip_ms, "release_s": found.release_ms, "cancel_s": found.cancel_ms}


@pytest.mark.timeout(600)
@pytest.mark.parametrize("steps", SIZES)
def test_they_are_the_worst_cases_of_any_tool(steps: int, tmp_path: Path) -> None:
    tool = drawn(steps, tmp_path / "tool.yaml", steps=steps, held=False)
    assert worst_cases(tool) == formula(tool)


@pytest.mark.timeout(600)
@pytest.mark.parametrize("seed", SEEDS)
def test_they_are_never_less_than_the_worst_case_whatever_the_endings(seed: int, tmp_path: Path) -> None:
    tool = drawn(seed, tmp_path / "tool.yaml", steps=1 + seed % 3, held=True)
    worst, computed = worst_cases(tool), formula(tool)
    assert worst["release_s"] == computed["release_s"], "a Drop releases all"
    for key, longest in worst.items():
        assert longest is None or longest <= computed[key]


def test_what_is_written_is_required_as_it_stands(tmp_path: Path) -> None:
    shipped = load(profile_path()).durations
    assert (shipped.grip_ms, shipped.release_ms, shipped.cancel_ms, shipped.computed) == (
        58_000,
        6_200,
        6_200,
        (),
    )
    text = profile_path().read_text(encoding="utf-8").replace("  release_s: 6.2\n", "")
    (tmp_path / "tool.yaml").write_text(text, encoding="utf-8")
    durations = load(tmp_path / "tool.yaml").durations
    assert (durations.grip_ms, durations.release_ms, durations.computed) == (58_000, 6_150, ("release_s",))


# Every requirement holds whatever the endings are, and the requirements tell them apart.


HOLD, RELEASE, LEAVE = "hold", "release", "leave"
EVERY: dict[str, Any] = {"cancel": HOLD, "timeout": HOLD, "abort": HOLD, "process_death": HOLD}
TOOLS = {
    "each in its own way": declared(
        changer={"process_death": LEAVE},
        bottom_vacuum={"gripping": {"cancel": HOLD, "process_death": HOLD}},
        cylinder={"gripping": {"timeout": HOLD, "abort": HOLD}, "held": {"process_death": LEAVE}},
        top_vacuum={"gripping": {"abort": HOLD}},
    ),
    "a held part may drop": declared(
        {"held": {"lost": RELEASE, "process_death": RELEASE}, "power_up": RELEASE}, il_09=False
    ),
    "a gripping that holds all": declared({"gripping": EVERY}),
    "some of a held part may drop": declared(
        il_09=False,
        bottom_vacuum={"held": {"lost": RELEASE}, "gripping": {"timeout": HOLD}},
        cylinder={"power_up": RELEASE, "held": {"process_death": RELEASE}},
    ),
}


def proof_of(description: Description) -> Proof:
    return prove(load_network(description.automata_path, model_constants(description)))


@pytest.mark.timeout(600)
@pytest.mark.parametrize("tool", first_of(TOOLS, thinned=0))
def test_every_requirement_holds(tool: str) -> None:
    proof = proof_of(TOOLS[tool])
    assert [finding.id for finding in proof.findings if not finding.holds] == []
    assert proof.states < 60_000  # the shipped tool: 38,000
    cancel, release = proof.bounds["cancel_s"], proof.bounds["release_s"]
    assert release.computed_ms == 6150
    # what is held is not waited for
    assert cancel.computed_ms == {"a gripping that holds all": None, "each in its own way": 4100}.get(
        tool, 6150
    )
