"""Automata that do not fit to the description."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from tests.unit.cli.check.shipped import SHIPPED, Check, sentences


@pytest.mark.parametrize(
    ("old", "new"),
    [("</nta>", ""), ("ATTEMPTS[i]", "ATTEMPTZ[i]"), ("<template>", "<tmplate>")],
    ids=["cut off", "unknown name", "unknown element"],
)
def test_broken_automata_are_found(check: Check, tmp_path: Path, old: str, new: str) -> None:
    text = profile_path().with_name("end_effector.xml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "end_effector.xml").write_text(text.replace(old, new, 1), encoding="utf-8")
    result = check()
    assert (result.exit_code, result.stdout) == (2, "")
    assert "Traceback" not in result.stderr
    assert result.stderr.startswith(str(tmp_path / "end_effector.xml") + ":")
    (said,) = sentences(result)
    assert said.endswith("[EE-300]")
    fault = json.loads(check("--json").stdout)["faults"][0]
    assert (fault["code"], fault["file"]) == ("EE-300", str(tmp_path / "end_effector.xml"))
    assert fault["line"] > 0


def test_automata_without_a_constant_of_the_description(check: Check, tmp_path: Path) -> None:
    text = profile_path().with_name("end_effector.xml").read_text(encoding="utf-8")
    own = tmp_path / "end_effector.xml"
    own.write_text(text.replace("ATTEMPTS", "TRIES"), encoding="utf-8")
    result = check()
    assert result.exit_code == 2
    assert result.stderr.startswith(f"{own}: declares no global constant 'ATTEMPTS'.")


def test_a_process_that_the_automata_do_not_have_is_found(check: Check) -> None:
    result = check(replace={"bounds:": "automata: {executed: [Griper, Actuator]}\nbounds:"})
    assert result.exit_code == 2
    line = SHIPPED[: SHIPPED.index("bounds:")].count("\n") + 1
    assert result.stderr.startswith(f"tool.yaml:{line}:11: ")
    assert "Griper" in result.stderr
    assert "Gripper" in result.stderr


@pytest.mark.parametrize("key", ["timeout_s: 5.0", "release_s: 2.0", "reset_s: 1.0"])
def test_a_time_below_the_units_of_the_model_is_refused(check: Check, key: str) -> None:
    result = check(replace={key: f"{key.split(':')[0]}: 1e-300"})
    assert result.exit_code == 2
    assert "is out of range (1e-300), expected at least 0.001 and at most 600 s" in result.stderr
