"""Tools that switches prove: checked, proved, and played by real processes against the testbench."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.command import eehal, eehal_here
from tests.support.nightly import first_of

pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]
TOOLS = Path("tests/unit/kinds/tools").absolute()
HELD = {"gripper": "CLOSED", "magnet": "ON", "vacuum_switch": "CLOSED"}
NAMES = first_of(["gripper", "magnet", "vacuum_switch"], 0, 1)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_checked_and_proved(name: str) -> None:
    eehal_here("check", TOOLS / f"{name}.yaml")
    proof = json.loads(eehal_here("verify", TOOLS / f"{name}.yaml", "--json"))
    assert proof["requirements"]
    assert all(each["holds"] for each in proof["requirements"])


@pytest.mark.parametrize("name", NAMES)
def test_it_is_played_and_recorded_in_its_words(name: str, tmp_path: Path) -> None:
    eehal("demo", TOOLS / f"{name}.yaml", "--no-ros", "--only", "nominal", "-o", tmp_path)
    rows = (tmp_path / "nominal" / "states.csv").read_text("utf-8").splitlines()[1:]
    states = [int(row.split(",")[-1]) for row in rows]
    assert list(dict.fromkeys(states)) == [0, 1, 2]
    assert states[-1] == 0
    figure = (tmp_path / "nominal" / "timeline.svg").read_text("utf-8")
    assert f">{HELD[name]}<" in figure
    told = json.loads(eehal_here("plot", tmp_path / "nominal", "-o", tmp_path / "again.svg", "--json"))
    assert told["verdict"] == "Nominal: GRIPPED, then dropped"
