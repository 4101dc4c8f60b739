"""The boundary of a program: its inputs and outputs, recorded as they happen."""

from ._open import DESCRIPTION, MODEL, open_recorder, open_stream, whole
from ._recorded_controller import AnyController, RecordedController, feed
from ._recorder import NULL_RECORDER, Observer, Recorder
from ._records import (
    DECIDED,
    INPUTS,
    KINDS,
    OBSERVED,
    STATE,
    STREAMED,
    FrameTaken,
    Header,
    LinesWritten,
    Published,
    Start,
    entry_of,
)
