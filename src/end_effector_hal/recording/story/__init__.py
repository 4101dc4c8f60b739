"""What happened in a recording, in words and as marks for a figure; read from its tables alone."""

from ._reader import tell
from ._story import Attempt, AttemptOutcome, Decision, Grip, Moment, Release, ReleaseCause, Reset, Story

__all__ = [
    "Attempt",
    "AttemptOutcome",
    "Decision",
    "Grip",
    "Moment",
    "Release",
    "ReleaseCause",
    "Reset",
    "Story",
    "tell",
]
