"""The history of a tool from its recordings: real tools in virtual time, and whatever else stands in the folder."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from end_effector_hal.cli._history import plotted
from end_effector_hal.description import Description, content_hash, profile_path
from end_effector_hal.page.recorded import _history, read_history
from end_effector_hal.page.recorded.__main__ import answer
from end_effector_hal.recording import GripDecision
from tests.support.named_parts import gripper_with_parts
from tests.support.recorded_days import run_of
from tests.support.trace_recordings import CANCELLED, FAILS_ONCE, INFO, NEVER, NOMINAL, log, written
from tests.support.virtual_tool import VirtualTool
from tests.unit.conftest import Whole

REAL = replace(INFO, scenario="", simulated=False)
NAMES = ["bottom_vacuum", "cylinder", "top_vacuum"]


def test_a_seal_that_wears_is_seen_before_a_grip_fails(tmp_path: Path, verdin: Description) -> None:
    """The leak of the lower cups grows from day to day, and every grip succeeds."""
    folders = [
        run_of(tmp_path / str(day), verdin, f"leak:bottom_vacuum:{0.5 * (day + 1)}", day) for day in range(6)
    ]
    found = read_history(verdin, reversed(folders))
    assert [grip.decision for grip in found.grips] == [GripDecision.GRIPPED] * 6
    assert [grip.at for grip in found.grips] == sorted(grip.at for grip in found.grips)
    assert not found.notes
    margins = {name: [grip.margin_kpa[name] for grip in found.grips] for name in NAMES}
    times = {name: [grip.confirm_s[name] for grip in found.grips] for name in NAMES}
    assert all(later < before - 0.5 for before, later in pairwise(margins["bottom_vacuum"]))
    assert times["bottom_vacuum"][-1] > times["bottom_vacuum"][0] + 0.02
    for name in NAMES[1:]:
        assert max(margins[name]) - min(margins[name]) < 1
        assert max(times[name]) - min(times[name]) < 0.05


def test_the_margin_is_that_of_the_readings_before_the_drop(tmp_path: Path, verdin: Description) -> None:
    folder = run_of(tmp_path / "run", verdin, "nominal", 0)
    (grip,) = read_history(verdin, [folder]).grips
    recorded = VirtualTool(verdin)
    recorded.play(1.5, "grip", 3.0)
    readings = recorded.controller.senses.now.readings
    below = -(readings.get("bottom", recorded.at) or 0) / 1000
    lost_kpa = verdin.actuators["bottom_vacuum"].lost_kpa  # type: ignore[attr-defined]
    # the table has steady pressures to 0.2 kPa
    assert grip.margin_kpa["bottom_vacuum"] == pytest.approx(below - lost_kpa, abs=0.3)


def test_parts_have_rows_of_their_own_and_their_own_thresholds(tmp_path: Path) -> None:
    tool = gripper_with_parts(tmp_path)
    folder = run_of(tmp_path / "run", tool, "nominal", 0, ("panel", "box", "box"))
    found = read_history(tool, [folder])
    assert [(row["part"], row["grips"]) for row in found.rows()] == [("box", 2), ("panel", 1)]
    panel, box, _ = found.grips
    assert list(panel.margin_kpa) == NAMES
    assert list(box.margin_kpa) == ["bottom_vacuum"]
    # 50 kPa below ambient lose the panel, 30 the box
    assert box.margin_kpa["bottom_vacuum"] - panel.margin_kpa["bottom_vacuum"] == pytest.approx(20, abs=1)
    assert [grip.part for grip in read_history(tool, [folder], "box").grips] == ["box", "box"]


def test_outcomes_and_first_attempts_by_day(tmp_path: Path, verdin: Description) -> None:
    logs = {"a": NOMINAL, "b": FAILS_ONCE, "c": NEVER, "d": CANCELLED}
    folders = [written(tmp_path / name, states, REAL) for name, states in logs.items()]
    folders.append(written(tmp_path / "e", NOMINAL, replace(REAL, started="2026-03-05T10:20:30+00:00")))
    found = read_history(verdin, folders)
    first, second = found.rows()
    assert first["outcomes"] == {"GRIPPED": 2, "ABORTED": 1, "CANCELLED": 1}
    assert first["first_attempt_rate"] == round(1 / 3, 4)  # a person has cancelled the fourth
    assert (second["grips"], second["first_attempt_rate"]) == (1, 1.0)
    # the time of the attempt that was confirmed, not of those before it
    assert first["actuators"]["cylinder"]["confirm_s"] == {"median": 0.625, "least": 0.5, "most": 0.75}
    assert first["actuators"]["cylinder"]["margin_kpa"] is None  # there is no table of pressures


def test_simulated_runs_count_only_if_there_are_no_others(tmp_path: Path, verdin: Description) -> None:
    simulated = written(tmp_path / "simulated", NEVER)
    real = written(tmp_path / "real", NOMINAL, REAL)
    alone = read_history(verdin, [simulated])
    assert (len(alone.grips), alone.notes[0]) == (1, "All of these grips were simulated.")
    found = read_history(verdin, [simulated, real])
    assert found.recordings == [str(real)]
    assert "1 simulated recordings are left out." in found.notes
    assert any(content_hash(verdin) in note and INFO.hash in note for note in found.notes)


def test_damaged_and_foreign_recordings_are_named_and_left_out(whole: Whole, tmp_path: Path) -> None:
    runs, tool = tmp_path / "runs", profile_path()
    written(runs / "good", NOMINAL, REAL)
    expected = {
        "noise": "states.csv:1: The header",
        "cut": "fields",
        "backwards": "states.csv:11: Time runs backwards",
        "other": "other actuators (left)",
        "named": "it is of the tool press",
        "kinds": "other actuators",
        "model": "run of the model",
        "undated": "does not say when it began",
        "no-events": "no events.csv",
        "pipe": "this is no file",
    }
    for name in expected:
        info = {
            "named": replace(REAL, description="press"),
            "kinds": replace(REAL, actuators={**REAL.actuators, "cylinder": "magnet"}),
            "model": replace(REAL, scenario="counterexample"),
            "undated": replace(REAL, started="yesterday"),
            "other": replace(REAL, actuators={}),
        }.get(name, REAL)
        written(runs / name, log((0.0, 6, -1, 0), names=("left",)) if name == "other" else NOMINAL, info)
    for name in ("noise", "pipe"):
        (runs / name / "states.csv").unlink()
    (runs / "noise" / "states.csv").write_bytes(os.urandom(2000))
    os.mkfifo(runs / "pipe" / "states.csv")
    with (runs / "cut" / "events.csv").open("a") as file:
        file.write("99.0,confirmed\n100.0,confirmed\n")
    with (runs / "backwards" / "states.csv").open("a") as file:
        file.write("1.000000,1,2,0,0,0\n")
    (runs / "no-events" / "events.csv").unlink()
    (runs / "good" / "pressures.csv").write_text("time_s,bottom_gauge_kpa\n0.0,much\n")
    code, out, err = whole("history", tool, "--recordings", runs, "--json")
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert (found["grips"], found["recordings"]) == (1, [str(runs / "good")])
    for name, why in expected.items():
        (note,) = (each for each in found["notes"] if str(runs / name) in each)
        assert why in note
    assert any("margins are not known" in note and "'much'" in note for note in found["notes"])


def test_there_is_an_end_to_what_is_read(
    tmp_path: Path, verdin: Description, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = [written(tmp_path / str(number), NOMINAL, REAL) for number in range(4)]
    for number, folder in enumerate(folders):
        os.utime(folder / "states.csv", (number, number))
    monkeypatch.setattr(_history, "MOST_RECORDINGS", 3)
    monkeypatch.setattr(_history, "MOST_GRIPS", 1)
    found = read_history(verdin, folders)
    assert found.recordings == [str(folders[3]), str(folders[2])]
    assert found.notes[0].startswith("4 recordings are too many")
    assert any("More than 1 grips" in note for note in found.notes)
    monkeypatch.setattr(_history, "MOST_BYTES", 10)
    assert not read_history(verdin, folders).grips


def test_the_command_prints_a_table_and_plots(whole: Whole, tmp_path: Path, verdin: Description) -> None:
    for day in range(3):
        run_of(tmp_path / "runs" / str(day), verdin, f"leak:bottom_vacuum:{day + 1}", day)
    code, out, err = whole("history", profile_path(), "--recordings", tmp_path / "runs")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "verdin_gripper: 3 grips in 3 recordings, 2026-03-02 to 2026-03-04"
    assert lines[2].split() == ["2026-03-02", "1", "1", "100%"]
    titles = [line.partition(";")[0] for line in lines if ";" in line]
    assert titles[:2] == [
        "Bottom vacuum: time to confirm, s (time-out 5 s)",
        "Bottom vacuum: margin at the end of the hold, kPa",
    ]
    assert len(titles) == 6


def test_the_page_has_the_same_facts(whole: Whole, tmp_path: Path, verdin: Description) -> None:
    for day in range(2):
        run_of(tmp_path / "runs" / str(day), verdin, f"leak:bottom_vacuum:{day + 1}", day)
    (tmp_path / "runs" / "linked").mkdir()
    for file in (tmp_path / "runs" / "0").iterdir():
        (tmp_path / "runs" / "linked" / file.name).symlink_to(file)
    of_page = json.loads(answer("history", tmp_path / "runs", str(profile_path())))
    shutil.rmtree(tmp_path / "runs" / "linked")
    of_command = json.loads(whole("history", "--json", profile_path(), "--recordings", tmp_path / "runs")[1])
    assert of_page["said"] == "verdin_gripper: 2 grips in 2 recordings, 2026-03-02 to 2026-03-03"
    assert {**of_page, "ok": True, "schema_version": of_command["schema_version"]} == of_command
    margin = next(each for each in of_page["trends"] if each["title"].startswith("Bottom vacuum: margin"))
    first, last = margin["values"]
    assert (margin["top"], margin["ends"]) == (first, f"first {first:.1f}, last {last:.1f}, worst {last:.1f}")


@pytest.mark.parametrize("where", ["nothing", "empty", "file"])
def test_without_a_grip_it_says_what_to_do(whole: Whole, tmp_path: Path, where: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("x")
    code, out, err = whole("history", profile_path(), "--recordings", tmp_path / where)
    assert (code, out) == (2, "")
    assert "No recording has a grip of this tool" in err
    code, _, err = whole("history", profile_path(), "--part", "box")
    assert code == 2
    assert "no part 'box'" in err


def test_bars_reach_from_zero_to_the_greatest_value() -> None:
    assert plotted([4.0, 2.0, 1.0, 0.0, -1.0], 4.0, 2) == ["█    ", "██▄▁x"]
