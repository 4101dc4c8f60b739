"""What another description would have made of a recorded run: its whole story beside the recorded one."""

from ._changed import MOST_TEXT, NAME, changed_description, changes, in_short
from ._other_run import GUESS, GUESS_OVER, OtherRun
from ._run_story import RunStory
from ._spans import ApartSpan
from ._what_if import LinePair, WhatIf, what_if
