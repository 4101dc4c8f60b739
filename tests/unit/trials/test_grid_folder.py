"""The folder of a matrix: kept lines that contradict themselves, an FMEA that somebody signs, the folder of a cell."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

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
    cell_folder,
    disturbances,
    fmea,
    matrix_folder,
    play_all,
    record,
    signed_cells,
)
from end_effector_lab.workers import LocalWorkers, open_workers

SHIPPED = load(profile_path())
REST = Moment("rest", 2_000_000, "rest", ())
CELLS = [Cell("nominal", REST, "cancel"), Cell("nominal", REST, "lock")]
LEAKS = [Cell("leak:top_vacuum:4", REST, "none"), Cell("leak:bottom_vacuum:4", REST, "none")]


@cache
def played() -> tuple[dict[str, Any], ...]:
    told = {"told": "The command was refused.", "told_after": 0.0}
    every = {"outcome": "refused", "seconds": 0.0, **told}
    return tuple({"id": cell.id, **every} for cell in CELLS + LEAKS)


def kept(folder: Path, *lines: dict[str, Any]) -> dict[str, Played]:
    """What a matrix of two cells makes of these lines."""
    with matrix_folder(SHIPPED, folder):
        pass
    (folder / "cells.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    with matrix_folder(SHIPPED, folder) as results:
        return play_all(SHIPPED, CELLS, results, workers=LocalWorkers(1))


def test_what_was_played_is_not_played_again(tmp_path: Path) -> None:
    first, second, *others = played()
    found = kept(tmp_path, first | {"told": "kept"}, second | {"told": "kept"}, *others)
    assert [(name, each.told) for name, each in found.items()] == [(cell.id, "kept") for cell in CELLS]


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"outcome": "triumph"}, "outcome"),
        ({"seconds": float("inf")}, "seconds"),
        ({"seconds": "0"}, "seconds"),
        ({"lines": [[0.1, "x", "on"]]}, "lines.0.2"),
        ({"lines": [0.1]}, "lines.0"),
        ({"told_after": {}}, "told_after"),
        ({"another": 1}, "another"),
    ],
)
def test_a_line_that_contradicts_itself_is_refused(
    changed: dict[str, Any], what: str, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=what) as error:
        kept(tmp_path, played()[1], played()[0] | changed)
    assert error.value.where == f"{tmp_path / 'cells.jsonl'}:2"


@pytest.mark.parametrize("name", list(played()[0]))
def test_a_line_that_lacks_something_is_refused(name: str, tmp_path: Path) -> None:
    line = {key: value for key, value in played()[0].items() if key != name}
    if name in ("told", "told_after"):  # nothing is their default
        assert len(kept(tmp_path, line, played()[1])) == 2
    else:
        with pytest.raises(UsageError, match=name):
            kept(tmp_path, line)


def test_a_cell_that_stands_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="earlier line"):
        kept(tmp_path, played()[0], played()[0])


def table(signed: bytes | None = None, cells: list[Cell] = LEAKS) -> bytes:
    return fmea(SHIPPED, cells, results_of(cells), signed_cells(signed)).encode()


def results_of(cells: list[Cell]) -> dict[str, Played]:
    return {
        each["id"]: Played(each["id"], Outcome.REFUSED, 0.0, "refused", 0.0)
        for each in played()
        if each["id"] in {cell.id for cell in cells}
    }


def filled(write: Callable[[list[dict[str, str]], StringIO], None]) -> bytes:
    rows = list(csv.DictReader(StringIO(table().decode(), newline="")))
    assert [row["severity"] for row in rows] == ["", ""]
    rows[0] |= {"severity": "7", "occurrence": "3"}
    text = StringIO(newline="")
    write(rows, text)
    return text.getvalue().encode()


def as_it_was(rows: list[dict[str, str]], text: StringIO) -> None:
    writer = csv.DictWriter(text, rows[0])
    writer.writeheader()
    writer.writerows(rows)


def by_a_spreadsheet(rows: list[dict[str, str]], text: StringIO) -> None:
    text.write("\ufeff")
    columns = ["remark", *reversed(rows[0])]
    writer = csv.DictWriter(text, columns, delimiter=";", quoting=csv.QUOTE_ALL, lineterminator="\n")
    writer.writeheader()
    writer.writerows({**row, "remark": "x;y"} for row in reversed(rows))


@pytest.mark.parametrize("write", [as_it_was, by_a_spreadsheet])
def test_what_somebody_signed_stands_in_the_next_fmea(
    write: Callable[[list[dict[str, str]], StringIO], None],
) -> None:
    rows = list(csv.DictReader(StringIO(table(filled(write)).decode(), newline="")))
    assert [(row["severity"], row["occurrence"]) for row in rows] == [("7", "3"), ("", "")]


@pytest.mark.parametrize("data", [b"", b"\xff", b"\0", b"a,b\n1,2,3\n", b'"' * 200_000, b"x" * 200_000])
def test_what_is_no_fmea_says_nothing(data: bytes) -> None:
    assert signed_cells(data) == {}


def written(folder: Path, cells: list[Cell]) -> list[str]:
    with matrix_folder(SHIPPED, folder) as results:
        none = dict.fromkeys(("dropped", "let_go", "unexplained", "left_out", "not_played"), 0)
        found = {"cells": 2, **none, "dimensions": {}}
        return [each.name for each in _matrix._write(SHIPPED, cells, results_of(cells), found, results)]


def test_a_signed_fmea_is_never_lost(tmp_path: Path) -> None:
    path = tmp_path / "fmea.csv"
    assert written(tmp_path, LEAKS) == []
    signed = filled(as_it_was)
    path.write_bytes(signed)
    assert written(tmp_path, LEAKS) == []  # its bytes are those of the next one
    assert path.read_bytes() == signed
    path.write_bytes(filled(by_a_spreadsheet))
    assert written(tmp_path, LEAKS) == ["fmea-1.csv"]
    assert (path.read_bytes(), (tmp_path / "fmea-1.csv").read_bytes()) == (signed, filled(by_a_spreadsheet))
    assert written(tmp_path, LEAKS[1:]) == ["fmea-2.csv"]  # the row that was signed is not in it
    assert (tmp_path / "fmea-2.csv").read_bytes() == signed
    (tmp_path / "report.html").write_text("theirs")
    assert written(tmp_path, LEAKS[1:]) == ["report-1.html"]


def test_more_processes_than_the_machine_is_good_for_are_refused() -> None:
    with pytest.raises(UsageError, match="too many") as error:
        open_workers(None, 100_000)
    assert error.value.where == "--jobs"


def test_a_cell_replaces_a_cell_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("end_effector_lab.trials.cells_of", lambda *_: iter(CELLS))
    monkeypatch.setattr("end_effector_lab.trials.moments", lambda _: ())

    def run(name: str) -> BaseException | None:
        arguments = ["--cell", name, "-o", str(tmp_path)]
        result = CliRunner().invoke(_matrix.command, arguments)
        return None if isinstance(result.exception, SystemExit) else result.exception

    for cell in CELLS:
        assert run(cell.id) is None
        info = json.loads((tmp_path / "cell" / "run.json").read_text())
        assert (info["scenario"], info["simulated"], info["seed"]) == (cell.id, True, 0)
        assert (tmp_path / "cell" / "timeline.png").exists()
    (tmp_path / "cell" / "thesis.txt").write_text("mine")
    assert "'thesis.txt', which no cell" in str(run(CELLS[0].id))
    (tmp_path / "cell" / "thesis.txt").unlink()
    file = tmp_path / "cell" / "run.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"scenario": "leak:top_vacuum"}))
    assert "a recording that no cell" in str(run(CELLS[0].id))
    assert json.loads(file.read_text())["scenario"] == "leak:top_vacuum"
    assert [each.name for each in tmp_path.iterdir()] == ["cell"]


def test_a_cell_that_fails_leaves_the_one_before(tmp_path: Path) -> None:
    folder = tmp_path / "made" / "cell"
    for name in ("timeline.png", "alarms.csv"):
        with cell_folder(folder) as new:
            (new / "run.json").write_text(json.dumps({"scenario": CELLS[0].id}))
            (new / name).write_text(name)
    with pytest.raises(FileNotFoundError), cell_folder(folder) as new:
        (new / "timeline.png").rename(new / "run.json")
    assert sorted(each.name for each in folder.iterdir()) == ["alarms.csv", "run.json"]
    assert [each.name for each in folder.parent.iterdir()] == ["cell"]


def test_no_link_and_no_file_is_replaced_by_a_cell(tmp_path: Path) -> None:
    theirs, folder = tmp_path / "theirs", tmp_path / "cell"
    theirs.mkdir()
    for make in (lambda: folder.symlink_to(theirs), lambda: folder.write_text("mine")):
        make()
        with pytest.raises(UsageError, match="not a folder"), cell_folder(folder):
            pass
        folder.unlink()
    folder.mkdir()
    (folder / "run.json").symlink_to(theirs)
    with pytest.raises(UsageError, match=r"'run\.json', which no cell"), cell_folder(folder):
        pass


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
