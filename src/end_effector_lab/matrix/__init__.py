"""Every fault of the testbench at every moment of a run, with every command: what becomes of a tool, and what may."""

from ._cells import COMMANDS, Cell, cells_of, faults_of
from ._expected import ExpectedOutcome, expected
from ._fmea import fmea
from ._outcome import Outcome
from ._play import Played, outcome_of, play
from ._report import page, summary
from ._run import play_all
from ._script import GRIP, HELD, RELEASE, REST, Moment, moments
from ._timeline import record

__all__ = [
    "COMMANDS",
    "GRIP",
    "HELD",
    "RELEASE",
    "REST",
    "Cell",
    "ExpectedOutcome",
    "Moment",
    "Outcome",
    "Played",
    "cells_of",
    "expected",
    "faults_of",
    "fmea",
    "moments",
    "outcome_of",
    "page",
    "play",
    "play_all",
    "record",
    "summary",
]
