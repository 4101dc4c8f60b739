"""What another description would have made of a recorded run: its whole story beside the recorded one."""

from ._changed import MOST_TEXT, NAME, changed_description, changes, in_short
from ._other_run import GUESS, GUESS_OVER, OtherRun
from ._run_story import RunStory, StoryLine
from ._spans import ApartSpan
from ._what_if import GripPair, LinePair, WhatIf, paired_lines, what_if

__all__ = [
    "GUESS",
    "GUESS_OVER",
    "MOST_TEXT",
    "NAME",
    "ApartSpan",
    "GripPair",
    "LinePair",
    "OtherRun",
    "RunStory",
    "StoryLine",
    "WhatIf",
    "changed_description",
    "changes",
    "in_short",
    "paired_lines",
    "what_if",
]
