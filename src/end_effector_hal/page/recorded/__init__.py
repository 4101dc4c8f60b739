"""Convert a recording into one JSON document, with the same view code as the live page.

The document has the view of every moment, so that the browser can scrub without a server; `eehal page` serves it and
`eehal report` writes it into a file.
"""

from ._differences import ComparedRecording, compare_recordings
from ._document import FoldedRecording, RecordingPart, read_recording
from ._files import RecordingFiles
from ._folder import PROGRESS
from ._history import NO_GRIP, ToolHistory, read_history
from ._summary import judge_recording
from ._tables import RecordedTables
