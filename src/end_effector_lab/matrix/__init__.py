"""Every fault of the testbench at every moment of a run, with every command: what becomes of a tool, and what may."""

from ._cells import COMMANDS, Cell, cells_of, faults_of, thinned
from ._expected import LYING, ExpectedOutcome, expected
from ._fmea import SignedCells, fmea, signed_cells
from ._judging import AT_REST, Monitors, is_still, not_gripping
from ._outcome import Outcome
from ._play import Played, outcome_of, play
from ._report import let_go, page, summary
from ._run import FIGURES, FMEA, PAGE, matrix_folder, no_log, play_all
from ._script import GRIP, HELD, RELEASE, REST, Moment, moments
from ._switching import Switching, switchings
from ._timeline import cell_folder, record

__all__ = [
    "AT_REST",
    "COMMANDS",
    "FIGURES",
    "FMEA",
    "GRIP",
    "HELD",
    "LYING",
    "PAGE",
    "RELEASE",
    "REST",
    "Cell",
    "ExpectedOutcome",
    "Moment",
    "Monitors",
    "Outcome",
    "Played",
    "SignedCells",
    "Switching",
    "cell_folder",
    "cells_of",
    "expected",
    "faults_of",
    "fmea",
    "is_still",
    "let_go",
    "matrix_folder",
    "moments",
    "no_log",
    "not_gripping",
    "outcome_of",
    "page",
    "play",
    "play_all",
    "record",
    "signed_cells",
    "summary",
    "switchings",
    "thinned",
]
