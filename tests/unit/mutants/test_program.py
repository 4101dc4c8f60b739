"""``python -m tools.mutants``: a table, JSON, and the survivors by their place."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.errors import UsageError
from tools.mutants.__main__ import command

pytestmark = [pytest.mark.thinned, pytest.mark.timeout(300)]


def run(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(command, list(words), catch_exceptions=False)
    return result.exit_code, result.stdout


def test_a_sample_is_judged_and_the_table_adds_up() -> None:
    code, told = run("--template", "Arming", "--sample", "3", "--jobs", "1")
    assert (
        code == 0
    )  # the shipped tool has sensors of its stand: what is armed is judged with one that has none
    assert told.splitlines()[-3].split() == ["all", "3", "0", "0", "0", "0", "0"]


def test_json_has_each_mutant_and_the_same_seed_the_same_ones() -> None:
    words = ("--template", "Actuator", "--sample", "3", "--seed", "4", "--jobs", "2", "--json")
    code, told = run(*words)
    document = json.loads(told)
    assert next(iter(document.items())) == ("schema_version", 1)
    assert len(document["mutants"]) == sum(document["outcomes"].values()) == 3
    assert {each["template"] for each in document["mutants"]} <= {"Actuator", ""}  # and what it uses
    caught = [each for each in document["mutants"] if each["outcome"] == "caught"]
    assert caught
    assert all(each["caught_by"] for each in caught)
    assert (code, json.loads(run(*words)[1])) == (0, document)


def test_what_was_found_is_written(tmp_path: Path) -> None:
    path = tmp_path / "record.json"
    words = ("--template", "Arming", "--sample", "3", "--seed", "9", "--jobs", "1")
    code, _ = run(*words, "--record", str(path))
    record = json.loads(path.read_text(encoding="utf-8"))
    assert (code, record["judged"]) == (0, 3)
    assert record["of"] > 100
    assert record["edges"]


def test_only_what_is_executed_is_edited() -> None:
    with pytest.raises(
        UsageError, match=r"executes a template 'Sensors'.*Gripper, Actuator, Changer, Arming"
    ):
        run("--template", "Sensors")
