"""The figure of a cell says what was done to the tool, and when."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from end_effector_hal.description import load, profile_path
from end_effector_lab.figures import RecordedRun
from end_effector_lab.trials import Cell, Happening, Moment, disturbances, record

SHIPPED = load(profile_path())
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
