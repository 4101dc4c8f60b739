from __future__ import annotations

import json
from pathlib import Path

import pytest

from end_effector_hal.errors import UsageError
from end_effector_lab.testbench._records import Events, Record


def test_events(tmp_path: Path) -> None:
    events = Events(tmp_path / "events")
    events.line("SODIMM_208", True, 100, 130)
    events.frame(200, 7, {"bottom": -5, "locked": True, "top": None}, sent=False)
    lines = (tmp_path / "events").read_text().splitlines()  # before it is closed: it is there at once
    assert [json.loads(line) for line in lines] == [
        {"at": 100, "seen": 130, "line": "SODIMM_208", "level": 1},
        {"at": 200, "frame": 7, "sent": False, "values": {"bottom": -5, "locked": True, "top": None}},
    ]
    events.close()


def test_record(tmp_path: Path) -> None:
    record = Record(tmp_path / "record")
    record.frame(1_000_000, {"bottom": -78_250, "top": None, "locked": True})
    record.frame(1_020_000, {"bottom": 0, "top": 1, "locked": False})
    record.close()
    assert (tmp_path / "record").read_text() == (
        "time_s,bottom,top,locked\n0.000000,-78.250,,1\n0.020000,0.000,0.001,0\n"
    )


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="Give another path"):
        Events(tmp_path)
    full = Events("/dev/full")
    with pytest.raises(UsageError, match="No space left"):
        full.line("A", True, 0, 0)
    full.close()
