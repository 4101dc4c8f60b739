"""What a demo says while it plays: every state, also one that lasts for an instant."""

from __future__ import annotations

from io import StringIO
from pathlib import Path

from rich.console import Console

from end_effector_hal.description import load, profile_path
from end_effector_hal.recording import run_info
from end_effector_lab.demo._progress import Progress

BEGUN = "time_s,end_effector,command,bottom_vacuum,cylinder,top_vacuum\n0.0,6,-1,0,0,0\n"
ABORTED = "18.7,1,2,2,1,0\n18.8,2,3,2,0,0\n18.8,4,3,0,0,0\n"


def test_an_error_that_is_unwound_at_once_is_said(tmp_path: Path) -> None:
    states = tmp_path / "states.csv"
    progress = Progress(Console(file=StringIO()), "[1/1]", states, run_info(load(profile_path())))
    assert progress.news() == []
    states.write_text(BEGUN)
    assert progress.news() == ["STAND-BY"]
    states.write_text(BEGUN + ABORTED)
    assert progress.news() == [
        "GRIPPING, Bottom vacuum ON, Cylinder PENDING EXTEND",
        "GRIP ERROR, Bottom vacuum ON",
        "RELEASING",
    ]
    assert progress.news() == []
