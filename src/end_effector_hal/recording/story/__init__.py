"""What happened in a recording, in words and as marks for a figure; read from its tables alone."""

from ._reader import read_story
from ._story import Attempt, AttemptOutcome, Grip, GripDecision, Moment, Release, ReleaseCause, Reset, Story

__all__ = [
    "Attempt",
    "AttemptOutcome",
    "Grip",
    "GripDecision",
    "Moment",
    "Release",
    "ReleaseCause",
    "Reset",
    "Story",
    "read_story",
]
