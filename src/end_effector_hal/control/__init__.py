"""What the tool decides with: detectors, the executed automata, and their words; sans-IO."""

from ._constants import channels_of, model_constants
from ._controller import PROGRAMS, Controller
from ._levels import Cause, ChangerFault, ChangerState, Evidence, ToolEvidence
from ._margin import margin_pa
from ._predicates import E_STOP_CLOSED, LOCKED, NOTHING_GRIPPED, PARKED, Predicates, predicates_fitted
from ._senses import Senses
from ._snapshot import ControllerSnapshot
from ._stand import ToolPlace, tool_place
from ._status import Answer, Status, StepReport
from ._time import to_s, to_us
from ._will import will_of

__all__ = [
    "E_STOP_CLOSED",
    "LOCKED",
    "NOTHING_GRIPPED",
    "PARKED",
    "PROGRAMS",
    "Answer",
    "Cause",
    "ChangerFault",
    "ChangerState",
    "Controller",
    "ControllerSnapshot",
    "Evidence",
    "Predicates",
    "Senses",
    "Status",
    "StepReport",
    "ToolEvidence",
    "ToolPlace",
    "channels_of",
    "margin_pa",
    "model_constants",
    "predicates_fitted",
    "to_s",
    "to_us",
    "tool_place",
    "will_of",
]
