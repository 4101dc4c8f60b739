"""The FMEAs that are kept: of every tool, with nothing that is not explained, and the same wherever they are played."""

from __future__ import annotations

import csv
from collections.abc import Collection
from io import StringIO

import pytest

from end_effector_lab.trials import fmea, play
from tests.support.fmea import EVERY, KEPT, chosen, rows_of
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


def again(name: str, faults: Collection[str]) -> tuple[list[dict[str, str]], list[dict[str, str]]]:
    """The rows of some failure modes: played now, and as they are kept. Virtual time from a seed: the same anywhere."""
    description, cells, _ = chosen(name)
    some = [cell for cell in cells if cell.fault in faults]
    played = {cell.id: play(description, cell) for cell in some}
    rows = list(csv.DictReader(StringIO(fmea(description, some, played))))
    modes = {(row["item"], row["failure mode"]) for row in rows}
    return rows, [row for row in rows_of(name) if (row["item"], row["failure mode"]) in modes]


@pytest.mark.timeout(600)
def test_two_failure_modes_are_the_same_when_they_are_played_again() -> None:
    """Of a tool of whose cells one in four is played: a second each."""
    rows, kept = again("diy_text", {"never-confirms:cups", "stuck-release:cups"})
    assert len(rows) >= 4
    assert rows == kept


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", EVERY)
def test_every_table_is_the_same_when_it_is_played_again(name: str) -> None:
    """A third of the failure modes where there are many."""
    faults = sorted({cell.fault for cell in chosen(name)[1]})
    rows, kept = again(name, faults if len(faults) < 30 else faults[::3])
    assert rows == kept
