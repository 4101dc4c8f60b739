"""The FMEAs that are kept: of every tool, with nothing that is not explained, and the same wherever they are played."""

from __future__ import annotations

import csv
from io import StringIO

import pytest

from end_effector_lab.matrix import fmea, play
from tests.support.fmea import EVERY, KEPT, chosen, rows_of
from tests.support.nightly import NIGHTLY
from tests.support.places import ROOT

TOOLS = ROOT / "examples" / "tools"


def test_every_tool_has_one() -> None:
    examples = {path.parent.name for path in TOOLS.glob("*/end_effector.yaml")}
    assert EVERY.keys() == {"verdin_gripper", *examples}
    assert {path.stem for path in KEPT.glob("*.csv")} == EVERY.keys()


def test_every_example_links_to_its_own() -> None:
    for path in TOOLS.glob("*/README.md"):
        assert f"docs/reference/fmea/{path.parent.name}.csv" in path.read_text(encoding="utf-8"), path


@pytest.mark.parametrize("name", EVERY)
def test_nothing_is_unexplained(name: str) -> None:
    rows = rows_of(name)
    assert [row for row in rows if row["unexplained"] != "0"] == []
    assert {row["function"] for row in rows} == {"begin a grip", "grip", "hold", "release"}


@pytest.mark.thinned  # long
def test_one_is_the_same_when_it_is_played_again() -> None:
    """Virtual time from a seed: the same on every machine."""
    name, fault = "double_acting_jaw", "" if NIGHTLY else "stuck-release:jaw"
    description, cells, _ = chosen(name)
    some = [cell for cell in cells if fault in cell.fault]
    played = {cell.id: play(description, cell).as_json() for cell in some}
    again = list(csv.DictReader(StringIO(fmea(description, some, played))))
    assert len(again) >= 4
    assert again == [row for row in rows_of(name) if fault in row["failure mode"]]
