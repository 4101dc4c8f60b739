"""What the doctor says of the machine and its times."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from end_effector_hal.cli.doctor import _doctor, _machine
from end_effector_hal.cli.doctor._check_result import CheckResult, Level
from end_effector_hal.description import Description, load, profile_path
from tests.unit.cli.doctor.parts import Machine


def test_hints_about_time() -> None:
    def told(finding: CheckResult) -> tuple[Level, str]:
        return finding.level, finding.what

    assert told(_machine.kernel("#1 SMP PREEMPT_DYNAMIC x", realtime=False))[0] is Level.OK
    assert told(_machine.kernel("#1 SMP PREEMPT_RT x", realtime=False)) == (
        Level.OK,
        "kernel with PREEMPT_RT",
    )
    assert told(_machine.kernel("#1 SMP x", realtime=False))[0] is Level.WARNING
    assert told(_machine.load(2.0, 2)) == (Level.OK, "load 2.0 on 2 processors")
    assert told(_machine.load(1.1, 1))[0] is Level.WARNING
    assert told(_machine.lateness(25_000, 50_000))[0] is Level.OK
    assert told(_machine.lateness(25_001, 50_000))[0] is Level.WARNING
    assert told(_machine.lateness(99_000, None))[0] is Level.OK


def test_the_reaction_bound_is_that_of_the_description(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_machine, "worst_wake_up_us", lambda: 7_000)
    text = machine.path.read_text()
    machine.describe(text=text.replace("reaction_ms: 50", "reaction_ms: 10"))
    assert machine.findings("machine")[-1][:2] == (
        "warning",
        "worst of 50 wake-ups 7.0 ms late; the reaction bound is 10 ms",
    )


def test_the_shipped_description_is_the_default() -> None:
    result = CliRunner().invoke(_doctor.command, ["--only", "description"], catch_exceptions=False)
    description: Description = load(profile_path())
    assert result.stdout == (
        f"ok       description  {profile_path()}: {description.name} ({description.fingerprint()})\n"
    )
