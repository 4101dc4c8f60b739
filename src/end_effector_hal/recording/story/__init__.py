"""The story of a recording, derived from its events: in words, and as marks for a figure."""

from ._reader import read_story
from ._story import AttemptOutcome, Grip, GripDecision, Moment, ReleaseCause, Story
