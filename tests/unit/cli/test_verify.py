"""``eehal verify`` as it is used: one line each, exit codes, files, and sentences instead of tracebacks."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import main
from end_effector_hal.cli._verify import command
from end_effector_hal.description import profile_path
from tests.unit.timed_automata.explore.models import Template, document

PRESSES = Template(
    "P", ["up -> down; guard: x >= 2; do: x = 0", "down -> up; guard: x >= 1"], invariants={"down": "x <= 3"}
)
COUNTS = Template("P", ["a -> a; guard: x >= 2; do: n = n + 1, x = 0"], invariants={"a": "x <= 4"})


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(declarations: str, template: Template, *queries: tuple[str, str]) -> None:
    Path("model.xml").write_bytes(document(declarations, template, queries=queries))


def run(*words: str) -> Result:
    return CliRunner().invoke(command, list(words), catch_exceptions=False)


def test_a_model_that_holds() -> None:
    written(
        "clock x;",
        PRESSES,
        ("A[] not deadlock", "[alive] It goes on."),
        ("A[] P.down imply x <= 5", "[down]"),
    )
    result = run("--model", "model.xml")
    assert result.exit_code == 0
    lines = [re.sub(r"[\d.]+ s\b", "S", line) for line in result.stdout.splitlines()]
    assert lines[0] == "model.xml: 6 requirements"
    assert lines[1].startswith("holds  It goes on.  [alive; ")
    assert "  down               0.003 s  0.005 s" in result.stdout
    assert lines[-1].startswith("all 6 hold; ")


def test_json() -> None:
    written("clock x;", PRESSES, ("A[] P.down imply x <= 5", "[down] Soon up."), ("A[] P.up", "[up] Up."))
    result = run("--model", "model.xml", "--json")
    assert result.exit_code == 4
    answer = json.loads(result.stdout)
    assert set(answer) == {"requirements", "bounds", "switched_off", "computed_bounds"}
    down, up, *_ = answer["requirements"]
    assert set(down) == {"id", "sentence", "query", "holds", "states", "seconds"}
    assert (down["id"], down["sentence"], down["holds"]) == ("down", "Soon up.", True)
    assert (up["query"], up["holds"]) == ("A[] P.up", False)
    assert answer["bounds"] == {"down_s": {"computed": 0.003, "declared": 0.005}}


def test_a_counterexample_is_told_and_written() -> None:
    written("clock x;", PRESSES, ("A[] P.up", "[up] It stays up."))
    result = run("--model", "model.xml", "-o", "found")
    assert result.exit_code == 4
    assert "FAILS  It stays up." in result.stdout
    assert "2 ms  P up → down" in result.stdout
    assert "1 of 5 fail" in result.stdout
    assert "2 ms  P up → down" in Path("found/up/run.txt").read_text(encoding="utf-8")


def test_a_value_out_of_range_comes_with_its_run() -> None:
    written("clock x; int[0,2] n;", COUNTS, ("A[] n < 3", "[few] Few."))
    result = run("--model", "model.xml")
    assert result.exit_code == 4
    assert "FAILS  Every value stays in its range" in result.stdout
    assert "model.xml:1:" in result.stdout
    assert "n = 3 is out of its range [0,2]." in result.stdout
    assert "open   Few." in result.stdout
    assert "1 of 2 fail, 1 are not decided" in result.stdout


@pytest.mark.parametrize(
    ("declarations", "invariant", "query", "message"),
    [
        ("clock x;", "x <= 3", "A[] P.z", r"model\.xml:1:\d+: 'P' has no location and no variable 'z'"),
        ("clock x;", "x <= 3", "Pr[<=9](<> P.b)", r"model\.xml:1:\d+: .*statistical model checking"),
        ("clock x;", "x' == 0", "A[] true", r"model\.xml:1:\d+: .*stopwatch"),
        ("clock x, y;", "x - y <= 3", "A[] true", r"model\.xml:1:\d+: .*diagonal"),
        (
            "int n;",
            "n == 1",
            "A[] true",
            r"model\.xml:1:\d+: The invariant 'n == 1' does not hold in the initial",
        ),
        (
            "clock x;",
            "x < 0",
            "A[] true",
            r"model\.xml:1:\d+: The invariant 'x < 0' does not hold in the initial",
        ),
        ("struct { int a; } s;", "true", "A[] true", r"model\.xml:1:\d+: .*structure"),
    ],
)
def test_what_cannot_be_checked_is_said_with_its_place(
    declarations: str,
    invariant: str,
    query: str,
    message: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    written(declarations, Template("P", ["a -> b"], invariants={"a": invariant}), (query, ""))
    monkeypatch.setattr("sys.argv", ["eehal", "verify", "--model", "model.xml"])
    with pytest.raises(SystemExit) as ended:
        main()
    told = capsys.readouterr().err
    assert ended.value.code == 2
    assert re.search(message, told)
    assert "Traceback" not in told


@pytest.mark.parametrize("content", [b"", b"hello", b"<foo/>", b"<nta>", b"\x00\xff\x17"])
def test_files_that_are_no_model(
    content: bytes, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("odd.xml").write_bytes(content)
    monkeypatch.setattr("sys.argv", ["eehal", "verify", "--model", "odd.xml"])
    with pytest.raises(SystemExit) as ended:
        main()
    told = capsys.readouterr().err
    assert ended.value.code == 2
    assert told.startswith("odd.xml:1:")
    assert "Traceback" not in told


def test_the_shipped_tool() -> None:
    result = run("--json")
    assert result.exit_code == 0
    answer = json.loads(result.stdout)
    assert all(each["holds"] for each in answer["requirements"])
    assert answer["bounds"]["grip_s"] == {"computed": 57.9, "declared": 58.0}
    assert answer["computed_bounds"] == []


def test_a_fourth_actuator_needs_no_bounds() -> None:
    description = """
        name: tool
        link: {port: /dev/ttyS0}
        sequence: [cup, rod, cap, pad]
        actuators:
          cup: {kind: vacuum, line: A, channel: bottom}
          rod: {kind: cylinder, line: B, channel: cylinder}
          cap: {kind: vacuum, line: C, channel: top}
          pad: {kind: vacuum, line: D, channel: supply}
        supply: {channel: none}
    """
    Path("tool.yaml").write_text(description, encoding="utf-8")
    result = run("tool.yaml")
    assert result.exit_code == 0
    assert (
        "bounds that are not written are what the steps add up to: grip_s, release_s, cancel_s\n"
        in result.stdout
    )


def test_a_bound_that_is_too_small_fails_with_its_worst_case_and_its_figure() -> None:
    text = profile_path().read_text(encoding="utf-8")
    Path("tool.yaml").write_text(text.replace("release_s: 6.2", "release_s: 6.0"), encoding="utf-8")
    Path("end_effector.xml").write_bytes(profile_path().with_name("end_effector.xml").read_bytes())
    result = run("tool.yaml", "-o", "found")
    assert result.exit_code == 4
    assert "takes up to 6150 ms, 6000 ms are required" in result.stdout
    assert sorted(path.name for path in Path("found/release").iterdir()) == [
        "run.json",
        "run.txt",
        "states.csv",
        "timeline.png",
        "timeline.svg",
    ]
