"""What a matrix writes: its FMEA, and the recording of a cell."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_lab.commands import _matrix
from end_effector_lab.figures import RecordedRun
from end_effector_lab.trials import (
    Cell,
    FaultWords,
    Happening,
    Moment,
    Outcome,
    Played,
    disturbances,
    fmea,
    record,
)
from end_effector_lab.workers import open_workers

SHIPPED = load(profile_path())
REST = Moment("rest", 2_000_000, "rest", ())
CELLS = [Cell("nominal", REST, "cancel"), Cell("nominal", REST, "lock")]
LEAKS = [Cell("leak:top_vacuum:4", REST, "none"), Cell("leak:bottom_vacuum:4", REST, "none")]


def test_severity_and_occurrence_are_left_to_a_person() -> None:
    results = {each.id: Played(each.id, Outcome.REFUSED, 0.0, "refused", 0.0) for each in LEAKS}
    rows = list(csv.DictReader(StringIO(fmea(SHIPPED, LEAKS, results), newline="")))
    assert [(row["severity"], row["occurrence"]) for row in rows] == [("", ""), ("", "")]


def test_more_processes_than_the_machine_is_good_for_are_refused() -> None:
    with pytest.raises(UsageError, match="too many") as error:
        open_workers(None, 100_000)
    assert error.value.where == "--jobs"


def test_a_cell_is_recorded_into_a_new_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("end_effector_lab.trials.cells_of", lambda *_: iter(CELLS))
    monkeypatch.setattr("end_effector_lab.trials.moments", lambda _: ())
    arguments = ["--cell", CELLS[0].id, "-o", str(tmp_path)]
    assert CliRunner().invoke(_matrix.command, arguments).exit_code == 0
    info = json.loads((tmp_path / "cell" / "run.json").read_text())
    assert (info["scenario"], info["simulated"], info["seed"]) == (CELLS[0].id, True, 0)
    assert (tmp_path / "cell" / "timeline.png").exists()
    assert "not empty" in str(CliRunner().invoke(_matrix.command, arguments).exception)


@pytest.mark.parametrize(
    ("fault", "number"), [("leak:nan", None), ("stuck-release:inf", None), ("leak:nan:4", 4.0)]
)
def test_a_place_is_no_number(fault: str, number: float | None) -> None:
    assert FaultWords(fault).number == number


GRIPPING = Moment("grip cylinder on +1ms", 3_000_000, "grip", ("bottom_vacuum",))


@pytest.mark.parametrize(
    ("cell", "told"),
    [
        (Cell("leak:top_vacuum:4", GRIPPING, "none"), {3.0: "leak:top_vacuum:4"}),
        (Cell("leak:top_vacuum:4", GRIPPING, "drop"), {3.0: "leak:top_vacuum:4"}),
        (Cell("nominal", GRIPPING, "kill hal"), {3.0: "kill hal", 4.0: "started again"}),
        (
            Cell("silent-after:0", GRIPPING, "kill hal"),
            {3.0: "silent-after:0, kill hal", 4.0: "started again"},
        ),
        (
            Cell("nominal", GRIPPING, "kill arbiter", at_once=True),
            {3.0: "kill arbiter, started again at once"},
        ),
        (Cell("nominal", GRIPPING, "cancel"), {}),
    ],
)
def test_what_is_done_to_the_tool_is_told_with_its_time(cell: Cell, told: dict[float, str]) -> None:
    assert {each.time_s: each.text for each in disturbances(cell)} == told


def test_the_figure_has_a_line_and_its_words_at_that_instant(tmp_path: Path) -> None:
    cell = Cell("leak:bottom_vacuum:40", GRIPPING, "kill hal")
    record(SHIPPED, cell, tmp_path)
    run = RecordedRun.read(tmp_path / "states.csv")
    lanes = replace(run, missed=disturbances(cell)).figure("timeline").axes[0]
    words = {text.get_text() for text in lanes.texts if text.get_label() == "event"}
    assert {"leak:bottom_vacuum:40, kill hal", "started again"} <= words
    for at in (3.0, 4.0):
        assert [at, at] in [list(np.asarray(line.get_xdata())) for line in lanes.lines]


def test_a_recording_begins_when_the_tool_has_come_to_rest(tmp_path: Path) -> None:
    grip = Happening(1_500_000, "grip")
    record(
        SHIPPED,
        Cell("nominal", Moment("later", 3_000_000, "held", SHIPPED.sequence, (grip,)), "none"),
        tmp_path,
    )
    rows = (tmp_path / "states.csv").read_text().splitlines()
    assert [row[:10] for row in rows[1:3]] == ["0.000000,6", "1.500000,1"]
