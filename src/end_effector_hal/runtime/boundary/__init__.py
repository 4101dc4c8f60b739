"""The boundary of a program: what goes in and what comes out, recorded as it happens."""

from ._open import DESCRIPTION, MODEL, open_recorder
from ._recorded_controller import RecordedController
from ._recorder import NOBODY, Recorder
from ._records import DECIDED, INPUTS, KINDS, OBSERVED, STATE, Header

__all__ = [
    "DECIDED",
    "DESCRIPTION",
    "INPUTS",
    "KINDS",
    "MODEL",
    "NOBODY",
    "OBSERVED",
    "STATE",
    "Header",
    "RecordedController",
    "Recorder",
    "open_recorder",
]
