"""What happened in a recording, in words and as marks for a figure; read from its tables alone."""

from ._reader import tell
from ._story import Attempt, Cause, Decision, Grip, Moment, Outcome, Release, Reset, Story

__all__ = [
    "Attempt",
    "Cause",
    "Decision",
    "Grip",
    "Moment",
    "Outcome",
    "Release",
    "Reset",
    "Story",
    "tell",
]
