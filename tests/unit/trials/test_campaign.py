"""Random cases: what the judge finds, that a campaign goes on where it was stopped, and its command."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest
from click.testing import CliRunner

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime.outputs import OutputMapping
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.commands._campaign import command
from end_effector_lab.trials import (
    Campaign,
    CaseSource,
    CoverageMap,
    case_from_words,
    play_case,
)
from end_effector_lab.trials._campaign import PlayedRun
from end_effector_lab.trials._coverage import Reached
from tests.support.places import ROOT
from tests.unit.trials.mutants import MUTANTS

SHIPPED = load(profile_path())
KNOWN = CoverageMap(SHIPPED)
TOOLS = ROOT / "examples" / "tools"


def played(words: str, seed: int = 0) -> dict[str, str]:
    return play_case(SHIPPED, case_from_words(words, SHIPPED, seed=seed)).failures


def test_a_changer_with_one_bit_need_not_lock_to_be_usable() -> None:
    """One bit of the two never proves LOCKED, which is no fault of the tool."""
    changer = SHIPPED.tool_changer
    assert changer is not None
    tool = SHIPPED.model_copy(update={"tool_changer": changer.model_copy(update={"unlocked_bit": "none"})})
    assert play_case(tool, case_from_words("grip; wait 2; drop", tool)).failures == {}


THINNED = pytest.mark.thinned


@pytest.mark.parametrize(
    ("tool", "words", "seed"),
    [
        # what has been so before the case began, has been so for long
        ("", "wait 0.1; unlock", 0),
        # a switch that is off proves that a vacuum is gone, whatever is left of it
        pytest.param("six_cups", "", 0, marks=THINNED),
        # a wire that falls silent shows what it has shown last
        pytest.param("two_coil_changer", "scenario silent-after:0; grip", 0, marks=THINNED),
        # a vacuum that has just begun, and one that has just been lost, were not read yet
        pytest.param("", "grip; wait 0.069; cancel", 57385670, marks=THINNED),
        pytest.param("", "grip; wait 0.29; scenario lost-after:bottom_vacuum:1", 1398798426, marks=THINNED),
        # what a grip that was cancelled has switched off late (IL-10) is no attempt of the next one
        ("", "grip; cancel; grip", 0),
        # an unlock may wait for its proof until a last will has been executed
        ("", "grip; wait 0.5; kill all; start all; wait 0.46; unlock", 0),
        # a sensor lies that nothing is held, and nobody is there to switch the output off
        ("", "grip; end arbiter; wait 3; scenario shows:bottom_vacuum:0", 0),
        # fingers that have lost their part show it only at the end of their way
        pytest.param("two_coil_changer", "grip; wait 0.46; scenario no-part:jaw", 0, marks=THINNED),
        # no coil stays active behind an arbiter that is asked twice to end
        ("bistable_and_magnet", "grip; end arbiter; end arbiter", 0),
        # near its threshold a noisy sensor shows a vacuum as gone a moment before it is
        pytest.param("six_cups", "wait 3.64; drop", 91249183, marks=THINNED),
        # a device that has let go because it heard nothing is told only once its bus is read again
        pytest.param("epick_commanded", "grip; wait 0.6; kill arbiter; wait 9", 0, marks=THINNED),
        # its trouble is over when it was dropped, and a reset is accepted then
        ("epick_commanded", "grip; wait 2; scenario silent-after:0", 0),
        # what has stuck to a magnet falls when nothing sticks any more
        pytest.param(
            "bistable_and_magnet", "grip; wait 0.5; scenario sticks:magnet; wait 0.4; drop", 0, marks=THINNED
        ),
        # no sensor reads the air
        pytest.param("double_acting_jaw", "scenario supply:0; wait 2; grip", 0, marks=THINNED),
        # a line arbiter that has never heard of a release does what it was left before: it holds
        pytest.param("", "grip; wait 2; end arbiter; drop; kill all; start all", 0, marks=THINNED),
    ],
)
def test_the_rules_have_nothing_against_what_nobody_can_know(tool: str, words: str, seed: int) -> None:
    description = load(TOOLS / tool / "end_effector.yaml") if tool else SHIPPED
    case = case_from_words(words, description, seed=seed)
    assert play_case(description, case).failures == {}


def test_a_tool_that_vanishes_is_judged() -> None:
    """A leave to lift, and a grip, while there is no tool or the tool changer is in FAULT (IL-05)."""
    assert played("grip; wait 4; scenario no-tool; wait 3; scenario nominal; wait 2; drop") == {}
    assert played("scenario no-tool; wait 3; grip; wait 2; lock") == {}


def test_a_sensor_fault_outlives_a_reset_that_was_refused() -> None:
    """A campaign has found it: the line arbiter forgot the fault until the program latched it again."""
    assert played("scenario unlocked-shows:tool_changer:1; wait 8; reset; end hal") == {}


def test_a_reset_that_is_accepted_while_no_line_arbiter_is_there_counts() -> None:
    fault = "scenario unlocked-shows:tool_changer:1; wait 8; scenario nominal; wait 2"
    assert played(f"{fault}; kill arbiter; reset; start arbiter; wait 5; reset") == {}


def test_what_raises_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(_: object, status: Status, *__: object) -> tuple[()]:
        if status.ee == EndEffectorState.GRIPPING:
            raise ZeroDivisionError("by the mutant")
        return ()

    monkeypatch.setattr(OutputMapping, "last_will", breaks)
    assert played("grip")["crash"] == "crash: ZeroDivisionError: by the mutant"


def test_a_case_is_the_same_each_time() -> None:
    case = case_from_words("scenario noise:0.2; grip; wait 0.5; kill arbiter; start arbiter", SHIPPED, seed=3)
    assert play_case(SHIPPED, case).as_json() == play_case(SHIPPED, case).as_json()


def test_the_end_is_told_as_it_was_before_all_was_put_right() -> None:
    end = play_case(SHIPPED, case_from_words("grip; wait 2; kill hal", SHIPPED)).end
    assert end is not None
    assert str(end) == "not running; active: bottom_vacuum, cylinder, top_vacuum"
    assert end.moved == ("bottom_vacuum on", "cylinder on", "top_vacuum on")


def test_edges_that_are_switched_off_do_not_count() -> None:
    assert not any(
        name.startswith("Arming") for name in KNOWN.edges
    )  # the shipped tool has a sensor of its stand
    assert any(name.startswith("Gripper StandBy → Activate") for name in KNOWN.edges)
    assert any(name.startswith("Actuator(2) ") for name in KNOWN.edges)
    assert len(set(KNOWN.edges)) == len(KNOWN.edges)


def test_cases_are_drawn_from_what_was_kept() -> None:
    source, campaign = CaseSource(SHIPPED), Campaign(5, KNOWN)
    kept = case_from_words("grip; wait 1.234567; kill hal", SHIPPED)
    first = PlayedRun(0, 1, 1.0, kept, (77_000,), Reached({1}, {2}, {3}))
    assert campaign.may_draw(16)
    assert not campaign.may_draw(17)
    before = campaign.draw(16, source)
    for run in range(64):
        campaign.add(PlayedRun(run, 1, 1.0, None) if run else first)
    assert campaign.draw(16, source) == before  # it is drawn from what was there for it
    drawn = [campaign.draw(run, source) for run in range(17, 80)]
    assert sum(any(each.what == "kill hal" for each in case.happenings) for case in drawn) > 15
    times = {each.at for case in drawn for each in case.happenings}
    assert {76_000, 77_000, 78_000} & times


def test_all_that_is_drawn_can_be_played_and_read() -> None:
    source, random = CaseSource(SHIPPED), Random(1)
    cases = [source.fresh(random) for _ in range(300)]
    for case in cases:
        case = source.mutant(random, case, (1_000, 2_000_000), random.choice(cases))
        assert case_from_words(case.words, SHIPPED, seed=case.seed) == case
        assert 0 <= case.happenings[-1].at <= 60_000_000
    verbs = {each.verb for case in cases for each in case.happenings}
    assert verbs >= {"grip", "drop", "cancel", "unlock", "kill", "end", "start", "scenario", "disk", "power"}


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(command, arguments)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.output


def test_the_same_seed_gives_the_same_runs_in_a_new_folder(tmp_path: Path) -> None:
    found, runs = [], []
    for jobs in ("1", "2"):
        folder = tmp_path / jobs
        code, printed = run("--runs", "4", "--jobs", jobs, "-o", str(folder), "--json")
        found.append(json.loads(printed.splitlines()[-1]))
        runs.append((folder / "runs.jsonl").read_text())
        assert (code, found[0]["runs"], found[0]["failures"]) == (0, 4, 0)
    assert (found[0], runs[0]) == (found[1], runs[1])
    assert int(found[0]["edges"].split("/")[0]) > 20
    unreached = json.loads((folder / "unreached.json").read_text())
    assert len(unreached["edges"]) == len(KNOWN.edges) - int(found[0]["edges"].split("/")[0])
    assert set(unreached["edge_faults"]) == set(KNOWN.faults)
    refused = CliRunner().invoke(command, ["--runs", "1", "-o", str(folder)])
    assert "This folder is not empty: it holds 'runs.jsonl'." in str(refused.exception)


def test_the_command_plays_a_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "case"
    path.write_text("grip; wait 1.5; end hal")
    code, printed = run("--play", str(path))
    assert code == 0
    assert "nothing is wrong; it ended: not running; active: bottom_vacuum, cylinder, top_vacuum" in printed
    MUTANTS["a restart that adopts nothing"].patch(monkeypatch)
    code, printed = run("--play", str(path), "--json")
    assert code == 4
    assert "held" in json.loads(printed)["failures"]


def test_one_case_is_played_by_nobody_else(tmp_path: Path) -> None:
    (tmp_path / "case").write_text("grip")
    arguments = ["--play", str(tmp_path / "case"), "--scheduler", "tcp://127.0.0.1:8786"]
    assert "Leave --jobs and --scheduler out" in str(CliRunner().invoke(command, arguments).exception)


@pytest.mark.parametrize("words", ["grip; power", "grip; wait 3; power"])
def test_a_valve_of_two_coils_holds_without_power(words: str) -> None:
    """Found by a campaign: that its part is told as held after that is no failure."""
    jaw = load_tool(ROOT / "examples" / "tools" / "double_acting_jaw" / "end_effector.yaml")
    played = play_case(jaw, case_from_words(words, jaw, seed=0))
    assert not played.failures
    assert played.end is not None
    assert played.end.state == "GRIPPED"


def test_a_fault_that_came_too_late_for_one_grip_may_stop_the_next() -> None:
    fault = "scenario stuck-release:top_vacuum"
    assert played(f"grip; wait 3; drop; wait 0.2; {fault}; wait 6; grip; wait 4; drop") == {}
