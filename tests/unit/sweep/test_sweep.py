"""A grid over values of a description: the same verdicts as of descriptions that were edited by hand."""

from __future__ import annotations

import csv
import json
from io import StringIO
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._verify import command
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import load_automata
from end_effector_hal.errors import DescriptionError, ReportedError, UsageError
from end_effector_hal.verification.lemmas import prove_tool
from end_effector_lab.sweep import Axis, combinations, read_axis, sweep
from end_effector_lab.workers import LocalWorkers

TOOL = Path("examples/tools/diy_text/end_effector.yaml")
ACTUATOR = load_tool(TOOL).sequence[0]
TIMEOUT, GRIP = f"actuators.{ACTUATOR}.timeout_s", "bounds.grip_s"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a.b=1:3:1", ("1", "2", "3")),
        ("a.b=0.1:0.5:0.2", ("0.1", "0.3", "0.5")),
        ("a.b=1:2.4:0.5", ("1", "1.5", "2")),
        ("a.b=100:300:100", ("100", "200", "300")),
        ("a.b=hold,release", ("hold", "release")),
        ("a.b=5", ("5",)),
    ],
)
def test_values_of_an_axis(text: str, values: tuple[str, ...]) -> None:
    assert read_axis(text) == Axis("a.b", values)


@pytest.mark.parametrize(
    "text",
    [
        "a.b", "a.b=", "=1", "a..b=1", "a=1,,2", "a=1,1", "a=3:1:1", "a=1:2", "a=1:2:0", "a=1:2:-1",
        "a=x:y:z", "a=0:1:1e-30", "a=0:inf:1", "a=nan:1:1", "a=1:2:3:4",
    ],
)  # fmt: skip
def test_what_is_no_axis_is_refused(text: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_axis(text)
    assert caught.value.where == text
    assert "KEY=FROM:TO:STEP" in caught.value.todo


def test_combinations_are_bounded_and_each_key_stands_once() -> None:
    one, two = Axis("a", ("1", "2")), Axis("b", ("x", "y"))
    assert [tuple(each.values()) for each in combinations([one, two])] == [
        ("1", "x"),
        ("1", "y"),
        ("2", "x"),
        ("2", "y"),
    ]
    with pytest.raises(UsageError, match="name the same key"):
        combinations([one, one])
    many = Axis("c", tuple(map(str, range(101))))
    with pytest.raises(UsageError, match="10201 combinations"):
        combinations([many, Axis("d", many.values)])


def test_a_combination_has_the_verdict_of_a_file_that_says_the_same(tmp_path: Path) -> None:
    axes = [read_axis(f"{TIMEOUT}=2,0"), read_axis(f"{GRIP}=5,100")]
    with LocalWorkers(1) as workers:
        found = sweep(TOOL, axes, workers)
    assert [tuple(each.values.values()) for each in found] == [
        (timeout, grip) for timeout in ("2", "0") for grip in ("5", "100")
    ]
    assert [each.holds for each in found] == [False, True, False, False]
    assert [bool(each.refused) for each in found] == [False, False, True, True]
    assert "timeout_s" in found[2].refused
    assert found[0].fails[0] in ("grip", "grip-decided")
    assert found[0].why
    file, text = tmp_path / "end_effector.yaml", TOOL.read_text()
    edited = text.replace("channel: cup}", "channel: cup, timeout_s: 2}")
    assert edited != text
    file.write_text(f"{edited}\nbounds:\n  grip_s: 5\n")
    description = load_tool(file)
    proof = prove_tool(description, load_automata(description))
    assert found[0].fails == tuple(each.id for each in proof.findings if not each.holds)
    assert found[0].states == proof.states
    worst = proof.bounds["grip_s"].computed_ms
    assert worst is not None
    assert found[0].worst["grip_s"] == worst / 1000


@pytest.mark.parametrize(
    ("axis", "error", "said"),
    [
        (f"actuators.{ACTUATOR}.timeou_s=1", DescriptionError, "did you mean 'timeout_s'"),
        ("actuators.nobody.timeout_s=1", ReportedError, "nobody"),
        ("name.more=1", UsageError, "no key 'name.more'"),
        (f"{TIMEOUT}=[", UsageError, "not a value"),
    ],
)
def test_what_is_no_key_is_refused_before_anything_is_proven(
    axis: str, error: type[ReportedError], said: str
) -> None:
    with LocalWorkers(1) as workers, pytest.raises(error) as caught:
        sweep(TOOL, [read_axis(axis)], workers)
    assert said in str(caught.value)


@pytest.mark.thinned
def test_the_command_writes_a_table_and_json(tmp_path: Path) -> None:
    axes = ["--sweep", f"{TIMEOUT}=2", "--sweep", f"{GRIP}=5,0"]
    result = CliRunner().invoke(command, [str(TOOL), *axes, "--jobs", "1", "--json", "-o", str(tmp_path)])
    assert result.exit_code == 4, result.output  # none holds
    printed = json.loads(result.output)
    assert printed["hold"] == 0
    assert printed["axes"] == {TIMEOUT: ["2"], GRIP: ["5", "0"]}
    written = json.loads((tmp_path / "sweep.json").read_text())
    assert [each["fails"] for each in written["combinations"]] == [
        each["fails"] for each in printed["combinations"]
    ]
    rows = list(csv.DictReader(StringIO((tmp_path / "sweep.csv").read_text())))
    assert [row["verdict"] for row in rows] == ["fails", "refused"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--sweep", "a=1", "--all"], "Leave the other options out"),
        (["--jobs", "2"], "Add --sweep"),
        (["--sweep", "a=1", "-o", "map.png"], "-o names the folder of a sweep"),
        (["--sweep", "a=1", "--jobs", "2", "--scheduler", "tcp://127.0.0.1:1"], "Leave --jobs out"),
    ],
)
def test_options_that_do_not_go_together(options: list[str], said: str) -> None:
    result = CliRunner().invoke(command, [str(TOOL), *options])
    assert said in str(result.exception)
