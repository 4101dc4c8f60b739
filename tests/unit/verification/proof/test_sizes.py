"""One model for any tool: descriptions of other sizes are proved without touching the file."""

from __future__ import annotations

import time
from pathlib import Path
from resource import RUSAGE_SELF, getrusage

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load
from end_effector_hal.verification.proof import prove
from tests.support.nightly import NIGHTLY, first_of
from tests.unit.verification.proof.sizes import sized
from timed_automata import load_network

SIZES = [1, 2, 4, 8, 32, 64] if NIGHTLY else first_of([1, 2, 4], 1)

LIMIT_S = {1: 20, 2: 20, 4: 30, 8: 60, 32: 300, 64: 1200}
"""Of the processor: several times what docs/explanation/performance.md has, for machines that are busy or small."""
LIMIT_MIB = 4096


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("count", SIZES)
def test_every_requirement_holds_for_any_number_of_actuators(count: int, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(sized(count), encoding="utf-8")
    description = load(path)
    constants = model_constants(description)
    assert constants["N"] == count
    assert len(set(constants["T_CONFIRM"][0])) == min(count, 4)  # type: ignore[arg-type]
    begun = time.process_time()
    proof = prove(load_network(description.automata_path, constants))
    took_s, peak_mib = time.process_time() - begun, getrusage(RUSAGE_SELF).ru_maxrss / 1024
    print(f"{count} steps: {took_s:.1f} s of the processor, at most {peak_mib:.0f} MiB")  # noqa: T201
    assert took_s <= LIMIT_S[count]
    assert peak_mib <= LIMIT_MIB
    assert [finding.id for finding in proof.findings if not finding.holds] == []
    for name in ("grip", "release", "cancel"):
        worst = proof.bounds[f"{name}_s"]
        assert worst.computed_ms == worst.declared_ms  # the description allows what steps and times add up to
