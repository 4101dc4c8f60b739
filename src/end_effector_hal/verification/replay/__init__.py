"""Check a recorded run: does the controller decide the same, and was it a run of the network."""

from ._chain import SegmentEnd
from ._load import Entry, ProgramTrace, load_trace, runs_of, traces_of
from ._replay import Replay, replay
from ._review import Review, review

__all__ = [
    "Entry",
    "ProgramTrace",
    "Replay",
    "Review",
    "SegmentEnd",
    "load_trace",
    "replay",
    "review",
    "runs_of",
    "traces_of",
]
