"""What another description would have made of a recorded run: its whole story beside the recorded one."""

from ._other_run import OtherRun
from ._run_story import RunStory, StoryLine
from ._spans import ApartSpan
from ._what_if import GripPair, LinePair, WhatIf, paired_lines, what_if

__all__ = [
    "ApartSpan",
    "GripPair",
    "LinePair",
    "OtherRun",
    "RunStory",
    "StoryLine",
    "WhatIf",
    "paired_lines",
    "what_if",
]
