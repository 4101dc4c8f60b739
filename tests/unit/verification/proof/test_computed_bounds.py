"""Bounds that nobody wrote are what the steps add up to: never less than the worst case, and no more than that."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.verification.proof import prove
from tests.support.nightly import NIGHTLY, first_of
from timed_automata import load_network

pytestmark = pytest.mark.thinned  # long

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
