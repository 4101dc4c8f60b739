"""The lemma of two coils: it holds, its constants are those of the tool, and its cut is checked."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest
from click import Command
from click.testing import CliRunner, Result

from end_effector_hal.cli._verify import command as verify
from end_effector_hal.cli.model._model import command as model
from end_effector_hal.description import load
from end_effector_hal.errors import UsageError
from end_effector_hal.verification.lemmas import COILS_FILE, coil_constants
from end_effector_hal.verification.proof import Proof, kept_verdict, prove
from tests.support.nightly import first_of
from tests.unit.figures.layout_faults import layout_faults
from timed_automata import load_document, load_network

DOCUMENT = load_document(COILS_FILE)
ONE_KIND_ONLY = {
    0: {"pulse-over", "pulse-whole"},
    100: {"one-held", "pulse-whole"},
}
"""What says nothing of a held output, and of a pulsed one."""

TOOL = """
schema: 2
name: two_coils
lines: {{backend: gpiod}}
link: {{port: /dev/ttyUSB0, codec: ees1-ascii}}
sequence: [pusher]
actuators:
  pusher:
    kind: cylinder
    line: GPIO5
    opposite: {{line: GPIO6{pulse}}}
    channel: cylinder
    timeout_s: 1
    reset_s: {reset_s}
    release_s: 1
{changer}
"""


def tool(folder: Path, pulse: str = ", pulse_s: 0.1", reset_s: float = 0.4, changer: str = "") -> Path:
    path = folder / "tool.yaml"
    path.write_text(TOOL.format(pulse=pulse, reset_s=reset_s, changer=changer), encoding="utf-8")
    return path


def run(command: Command, *words: str) -> Result:
    return CliRunner().invoke(command, list(words), catch_exceptions=False)


@pytest.mark.parametrize("template", DOCUMENT.templates, ids=lambda each: each.name.content)
def test_it_reads_well(template) -> None:  # type: ignore[no-untyped-def]
    assert layout_faults(template) == []


@cache
def proof(pulse_ms: int, **constants: int) -> Proof:
    return prove(load_network(COILS_FILE, {"PULSE": pulse_ms, **constants}))


@pytest.mark.parametrize("pulse_ms", first_of(ONE_KIND_ONLY))
def test_all_of_it_holds(pulse_ms: int) -> None:
    found = proof(pulse_ms)
    assert found.holds
    assert {each.id for each in found.findings if each.remark} == ONE_KIND_ONLY[pulse_ms]


@pytest.mark.thinned  # long
def test_the_worst_cases_are_what_the_steps_add_up_to() -> None:
    """Each change waits for SWITCH and is D late; the arbiter hears within D; the coil has moved it just in time."""
    switch, d, pulse = 50, 50, 100
    on, off = proof(pulse).bounds.values()
    # the output has just changed, a deactivation waits, and 1 ms later an activation is decided
    assert on.computed_ms == 2 * (switch + d) + (pulse - 1) - 1
    # decided just before the output changes, heard of just after
    assert off.computed_ms == d + (switch + d) + (pulse - 1)


@pytest.mark.thinned  # long
def test_with_a_pause_all_of_it_holds_and_a_change_waits_for_the_whole_pulse_and_the_pause() -> None:
    d, pulse, pause = 50, 100, 300
    found = proof(pulse, PAUSE=pause)
    assert found.holds
    assert {each.id for each in found.findings if each.remark} == {"one-held"}
    on, off = found.bounds.values()
    assert off.computed_ms == d + (pulse + d) + (pause + d) + (pulse - 1)
    # the deactivation that waits has its own pulse and pause before the activation comes
    assert on.computed_ms == (pulse + d) + 2 * (pause + d) + (pulse + d) + (pulse - 1) - 1


def test_the_constants_are_those_of_the_tool(tmp_path: Path) -> None:
    changer = "tool_changer: {line: GPIO12, opposite: {line: GPIO13}, prove_s: 1.5}"
    assert coil_constants(load(tool(tmp_path, changer=changer))) == {
        "pusher": {
            "PULSE": 100, "PAUSE": 0, "SWITCH": 50, "LEASE": 1000, "D": 50, "T_ON": 1000, "T_OFF": 400,
        },
        "tool_changer": {
            "PULSE": 0, "PAUSE": 0, "SWITCH": 50, "LEASE": 1000, "D": 50, "T_ON": 1500, "T_OFF": 1500,
        },
    }  # fmt: skip


def test_eehal_verify_proves_the_tool_and_its_coils_and_keeps_the_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = tool(tmp_path)
    result = run(verify, str(path), "--json")
    assert result.exit_code == 0
    answer = json.loads(result.stdout)
    ids = [each["id"] for each in answer["requirements"]]
    assert {"held", "pusher.never-both", "pusher.position", "pusher.edges"} <= set(ids)
    assert answer["bounds"]["pusher.assumed_off_s"] == {"computed": 0.249, "declared": 0.4}
    verdict = kept_verdict(load(path))
    assert (verdict.holds, verdict.requirements) == (True, len(ids))


@pytest.mark.thinned  # long
def test_a_cut_that_does_not_hold_is_found_and_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pulse of 250 ms is over in a pause of 300 ms, but not if it began late."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    found = tmp_path / "found"
    result = run(verify, str(tool(tmp_path, ", pulse_s: 0.25", 0.3)), "-o", str(found))
    assert result.exit_code == 4
    lines = result.stdout.splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("FAILS"))
    assert lines[at].startswith("FAILS  The two coils of pusher: 7. The same of a deactivation")
    assert [line.strip() for line in lines[at + 1 : at + 3]] == [
        "takes up to 399 ms, 300 ms are required",
        "raise reset_s and release_s (of the tool changer prove_s), or shorten pulse_s and pause_s",
    ]
    assert (found / "pusher.assumed-off" / "run.txt").is_file()


def test_its_network_is_exported_with_the_constants_of_the_tool(tmp_path: Path) -> None:
    own = tmp_path / "coils.xml"
    assert run(model, "export", str(tool(tmp_path)), "--coils", "pusher", "-o", str(own)).exit_code == 0
    assert load_network(own).constants["T_OFF"] == 400
    assert run(model, "check", str(own)).exit_code == 0


def test_an_output_without_two_coils_has_none(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no output 'cup' with two coils\. Those with two coils are pusher"):
        run(model, "show", str(tool(tmp_path)), "--coils", "cup")
