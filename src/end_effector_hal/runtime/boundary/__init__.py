"""The boundary of a program: what goes in and what comes out, recorded as it happens."""

from ._open import DESCRIPTION, MODEL, open_recorder
from ._recorded_controller import AnyController, RecordedController
from ._recorder import NULL_RECORDER, Recorder
from ._records import DECIDED, INPUTS, KINDS, OBSERVED, STATE, Header

__all__ = [
    "DECIDED",
    "DESCRIPTION",
    "INPUTS",
    "KINDS",
    "MODEL",
    "NULL_RECORDER",
    "OBSERVED",
    "STATE",
    "AnyController",
    "Header",
    "RecordedController",
    "Recorder",
    "open_recorder",
]
