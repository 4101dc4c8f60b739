"""Every fault of the testbench at every moment of a run, with every command: what becomes of a tool, and what may."""

from ._cells import COMMANDS, Cell, cells_of, faults_of, thinned
from ._expected import LYING, ExpectedOutcome, expected
from ._fmea import fmea
from ._judging import AT_REST, Monitors, is_still, not_gripping
from ._kept_lines import kept_file, read_kept
from ._outcome import Outcome
from ._play import Played, outcome_of, play
from ._report import page, summary
from ._run import no_log, play_all
from ._script import GRIP, HELD, RELEASE, REST, Moment, moments
from ._switching import Switching, switchings
from ._timeline import record

__all__ = [
    "AT_REST",
    "COMMANDS",
    "GRIP",
    "HELD",
    "LYING",
    "RELEASE",
    "REST",
    "Cell",
    "ExpectedOutcome",
    "Moment",
    "Monitors",
    "Outcome",
    "Played",
    "Switching",
    "cells_of",
    "expected",
    "faults_of",
    "fmea",
    "is_still",
    "kept_file",
    "moments",
    "no_log",
    "not_gripping",
    "outcome_of",
    "page",
    "play",
    "play_all",
    "read_kept",
    "record",
    "summary",
    "switchings",
    "thinned",
]
