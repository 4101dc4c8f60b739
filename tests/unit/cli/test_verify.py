"""``eehal verify`` as it is used: one line each, exit codes, files, and sentences instead of tracebacks."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._verify import command
from end_effector_hal.description import SHIPPED_AUTOMATA, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import read_run
from end_effector_hal.verification.proof import Proof, prove
from tests.unit.conftest import Whole
from tests.unit.timed_automata.explore.models import document
from timed_automata import Network

PRESSES = "P: down: x <= 3 | up -> down; guard: x >= 2; do: x = 0 | down -> up; guard: x >= 1"
COUNTS = "P: a: x <= 4 | a -> a; guard: x >= 2; do: n = n + 1, x = 0"


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(declarations: str, template: str, *queries: tuple[str, str]) -> None:
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
    result = run("--model", "model.xml", "--all")
    assert result.exit_code == 0
    lines = [re.sub(r"[\d.]+ s\b", "S", line) for line in result.stdout.splitlines()]
    assert lines[0] == "Proving model.xml"
    assert lines[1].startswith("holds  It goes on.  [alive; ")
    assert "  down               0.003 s  0.005 s" in result.stdout
    assert lines[-1].startswith("all 7 hold; ")
    short = run("--model", "model.xml").stdout
    assert "[alive" not in short
    assert "  down               0.003 s  0.005 s" in short
    assert re.fullmatch(r"all 7 hold; .*  \(--all lists every requirement\)", short.splitlines()[-1])


def test_what_is_proven_is_written_before_the_proof_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    written("clock x;", PRESSES, ("A[] P.down imply x <= 5", "[down]"))
    arrived: list[bytes] = []

    def proving(network: Network, *words: Any, **options: Any) -> Proof:
        arrived.append(sys.stdout.buffer.getvalue())  # type: ignore[attr-defined]
        return prove(network, *words, **options)

    monkeypatch.setattr("end_effector_hal.verification.proof.prove", proving)
    run("--model", "model.xml")
    run("--model", "model.xml", "--json")
    assert arrived == [b"Proving model.xml\n", b""]


def test_json() -> None:
    written("clock x;", PRESSES, ("A[] P.down imply x <= 5", "[down] Soon up."), ("A[] P.up", "[up] Up."))
    result = run("--model", "model.xml", "--json")
    assert result.exit_code == 4
    answer = json.loads(result.stdout)
    assert set(answer) == {"schema_version", "requirements", "bounds", "switched_off", "computed_bounds"}
    down, up, *_ = answer["requirements"]
    assert set(down) == {"id", "sentence", "query", "holds", "states", "seconds", "why"}
    assert (down["why"], up["why"]) == ("", "At 2 ms: P must be in up, but it is in down.")
    assert (down["id"], down["sentence"], down["holds"]) == ("down", "Soon up.", True)
    assert (up["query"], up["holds"]) == ("A[] P.up", False)
    assert answer["bounds"] == {"down_s": {"computed": 0.003, "declared": 0.005}}


def test_a_counterexample_is_told_and_written() -> None:
    written("clock x;", PRESSES, ("A[] P.up", "[up] It stays up."))
    result = run("--model", "model.xml", "-o", "found")
    assert result.exit_code == 4
    assert "FAILS  It stays up." in result.stdout
    assert "2 ms  P up → down" in result.stdout
    assert "1 of 6 fail" in result.stdout
    text = Path("found/up/run.txt").read_text(encoding="utf-8")
    assert "2 ms  P up → down" in text
    assert text.endswith("\n\nAt 2 ms: P must be in up, but it is in down.\n")
    assert "  At 2 ms: P must be in up, but it is in down.\n" in result.stdout


def test_however_much_fails_it_is_told_on_a_page() -> None:
    counted = "P: a: x <= 4 | a -> a; guard: x >= 2; do: n = n + 1, x = 0"
    queries = [(f"A[] n < {number}", f"[few-{number}] Under {number}.") for number in range(20, 40)]
    written("clock x; int[0,100] n;", counted, *queries)
    Path("model.xml").write_text(
        Path("model.xml").read_text("utf-8").replace("n + 1", "n + (n &lt; 60)"), "utf-8"
    )
    short, whole = (run("--model", "model.xml", *words).stdout for words in ((), ("--all",)))
    assert len(short.splitlines()) < 50
    assert len([line for line in short.splitlines() if line.startswith("FAILS")]) == 6
    assert "14 fail as well: few-26, few-27" in short
    assert "At 42 ms: n must be less than 21, but it is 21." in short
    assert "steps more, which --all shows" in short
    assert len([line for line in whole.splitlines() if line.startswith("FAILS")]) == 20
    assert "At 78 ms: n must be less than 39, but it is 39." in whole
    assert "steps more" not in whole


def test_what_does_not_apply_is_counted_and_all_lists_it() -> None:
    written(
        "clock x; bool b;",
        PRESSES,
        ("A[] b imply P.up", "[empty] Never."),
        ("sup{P.down}: x", "[sup] How long."),
        ("sup: x", "[all] How long in all."),
    )
    told = run("--model", "model.xml").stdout
    assert ", 1 does not apply to this model; " in told
    assert "does not apply here: its condition is never met" in run("--model", "model.xml", "--all").stdout
    assert "holds  How long." in told
    assert "       3\n" in told
    assert "FAILS  How long in all." in told
    assert "sup of x: unbounded." in told
    written("clock x; bool b;", PRESSES, ("E<> b", "[never] It comes."))
    assert "FAILS  It comes." in (told := run("--model", "model.xml").stdout)
    assert "no run leads there" in told


FLICKERS = """P: down: x <= 3
    up -> down; guard: x >= 2; do: x = 0
    down -> up; guard: x >= 1
    up -> up; guard: FREE_SENSORS"""


def test_free_sensors_are_a_constant_of_the_file_and_need_not_let_time_diverge() -> None:
    written("const bool FREE_SENSORS = false; clock x;", FLICKERS, ("A[] P.down imply x <= 5", "[down]"))
    ordinary = run("--model", "model.xml", "--all")
    assert (ordinary.exit_code, "[time; " in ordinary.stdout, "not asked" in ordinary.stdout) == (
        0,
        True,
        False,
    )
    free = run("--model", "model.xml", "--all", "--free-sensors", "actuators")
    assert (free.exit_code, "[timelock; " in free.stdout, "[time; " in free.stdout) == (0, True, False)
    assert free.stdout.startswith("Proving model.xml, sensors free (actuators)\n")
    assert "not asked: that time diverges [time]" in free.stdout
    document = json.loads(run("--model", "model.xml", "--free-sensors", "actuators", "--json").stdout)
    assert document["free_sensors"] == "actuators"


def test_automata_that_cannot_set_them_free_are_told() -> None:
    written("const bool FREE_SENSORS = false; clock x;", FLICKERS)
    with pytest.raises(UsageError, match="no constant FREE_TOOL"):
        run("--model", "model.xml", "--free-sensors", "all")


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
        ("clock x;", "x' == 0", "A[] true", r"model\.xml:1:\d+: .*stopwatch"),
        ("clock x, y;", "x - y <= 3", "A[] true", r"model\.xml:1:\d+: .*diagonal"),
        ("int n;", "n == 1", "A[] true", r"model\.xml:1:\d+: The invariant 'n == 1' does not hold in the initial"),
        ("clock x;", "x < 0", "A[] true", r"model\.xml:1:\d+: The invariant 'x < 0' does not hold in the initial"),
        ("struct { clock a; } s;", "true", "A[] true", r"model\.xml:1:\d+: .*structure"),
    ],
)  # fmt: skip
def test_what_cannot_be_checked_is_said_with_its_place(
    declarations: str, invariant: str, query: str, message: str, whole: Whole
) -> None:
    written(declarations, f"P: a: {invariant} | a -> b", (query, ""))
    code, _, told = whole("verify", "--model", "model.xml")
    assert (code, bool(re.search(message, told))) == (2, True)


@pytest.mark.parametrize("content", [b"", b"hello", b"<foo/>", b"<nta>", b"\x00\xff\x17"])
def test_files_that_are_no_model(content: bytes, whole: Whole) -> None:
    Path("odd.xml").write_bytes(content)
    code, _, told = whole("verify", "--model", "odd.xml")
    assert (code, told[:10]) == (2, "odd.xml:1:")


def test_the_shipped_tool() -> None:
    result = run("--json")
    assert result.exit_code == 0
    answer = json.loads(result.stdout)
    assert all(each["holds"] for each in answer["requirements"])
    assert answer["bounds"]["grip_s"] == {"computed": 57.9, "declared": 58.0}
    assert answer["computed_bounds"] == []


@pytest.mark.thinned  # long
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
        "computed from times and attempts, for lack of `bounds:`: grip_s, release_s, cancel_s\n"
        in result.stdout
    )


@pytest.mark.thinned  # long
def test_a_bound_that_is_too_small_fails_with_its_worst_case_and_its_figure() -> None:
    text = profile_path().read_text(encoding="utf-8")
    Path("tool.yaml").write_text(text.replace("release_s: 6.2", "release_s: 6.0"), encoding="utf-8")
    Path("end_effector.xml").write_bytes(SHIPPED_AUTOMATA.read_bytes())
    result = run("tool.yaml", "-o", "found")
    assert result.exit_code == 4
    assert "takes up to 6150 ms, 6000 ms are required" in result.stdout
    assert "deactivate[top_vacuum]: " in Path("found/release/run.txt").read_text("utf-8")
    why = "then Observer.x must be at most RELEASE_BOUND (6 s), but it is 6.001 s."
    assert why in Path("found/release/run.txt").read_text("utf-8")
    info = read_run("found/release")
    assert why in info.because
    assert [each.name for each in info.watched] == ["Observer", "watched", "ee", "Observer.x"]
    assert [each.wrong for each in info.watched] == [False, False, False, True]
    (observer, watched, ee, clock) = info.watched
    assert [words for _, words in ee.values][-1] == "RELEASING"
    assert [words for _, words in watched.values] == ["NONE", "RELEASE"]
    assert clock.limits == (("<= RELEASE_BOUND (6 s)", 6.0),)
    assert clock.deadline_s == pytest.approx(info.violated_s - 0.001)
    assert observer.points == ()
    assert sorted(path.name for path in Path("found/release").iterdir()) == [
        "events.csv", "run.json", "run.txt", "states.csv", "timeline.png", "timeline.svg",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("A[] P.z", r"model\.xml:1:\d+: 'P' has no location and no variable 'z'"),
        ("Pr[<=9](<> P.b)", r"model\.xml:1:\d+: .*statistical model checking"),
    ],
)
def test_a_query_that_cannot_be_asked_is_open_and_the_others_are_answered(
    query: str, message: str, whole: Whole
) -> None:
    written("clock x;", "P: a -> b", ("E<> P.b", ""), (query, ""), ("A[] P.a", ""))
    code, told, _ = whole("verify", "--model", "model.xml")
    assert code == 4
    marks = [line.split()[0] for line in told.splitlines() if line.startswith(("holds", "open", "FAILS"))]
    assert marks == ["FAILS", "open"]
    assert re.search(message, told)
    assert "1 are not decided" in told


def test_a_proof_that_takes_too_much_memory_is_open(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = "P: a: x <= 1 | a -> a; guard: x >= 1; do: n = (n + 1) % 3000, x = 0"
    written("clock x; int[0,2999] n;", counts, ("A[] n >= 0", "[least] Not less."))
    monkeypatch.setattr("end_effector_hal.verification.proof._memory.TIMES_LEFT", 0)
    result = run("--model", "model.xml")
    assert result.exit_code == 4
    assert "6 not decided: stopped after 1,000 states, " in result.stdout
    assert "0 of 6 hold, 6 are not decided" in result.stdout


def test_a_verdict_that_was_stopped_is_not_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("end_effector_hal.verification.proof._memory.TIMES_LEFT", 0)
    assert run().exit_code == 4
    assert not (tmp_path / "state").exists()
