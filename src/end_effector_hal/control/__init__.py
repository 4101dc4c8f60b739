"""What the tool decides with: the executed automata and their words; sans-IO."""

from ._constants import model_constants
from ._controller import PROGRAMS, Controller
from ._snapshot import ControllerSnapshot
from ._status import Answer, Status, StepReport
from ._will import will_of

__all__ = [
    "PROGRAMS",
    "Answer",
    "Controller",
    "ControllerSnapshot",
    "Status",
    "StepReport",
    "model_constants",
    "will_of",
]
