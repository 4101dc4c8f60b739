"""What happened in a recording, in words and as marks for a figure; read from its tables alone."""

from ._reader import read_story
from ._story import AttemptOutcome, Grip, GripDecision, Moment, ReleaseCause, Story
