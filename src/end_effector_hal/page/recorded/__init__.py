"""A recording as the page shows it: its records are folded by the view of the live page into one JSON document.

The document has what is shown at every moment, so the browser scrubs it without asking anybody; `eehal page` serves it
and `eehal report` writes it into a file.
"""

from ._compared import ComparedRecording
from ._differences import compare_recordings
from ._document import FoldedRecording, RecordingPart, read_recording
from ._files import RecordingFiles
from ._folder import PROGRESS
from ._judged import judge_recording
from ._tables import RecordedTables
