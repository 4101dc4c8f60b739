"""What happened in a recording, in words and as marks for a figure: a fold of its events."""

from ._reader import read_story
from ._story import AttemptOutcome, Grip, GripDecision, Moment, ReleaseCause, Story
