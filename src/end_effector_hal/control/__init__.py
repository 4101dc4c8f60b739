"""What the tool decides with: the executed automata and their words; sans-IO."""

from ._constants import model_constants
from ._controller import PROGRAMS, Controller
from ._last_wills import GripLastWill, changer_will, ending_in_words, maintenance_will
from ._network import network_of
from ._snapshot import ControllerSnapshot
from ._status import Answer, Status, StepReport, told_to_grip
from .words import (
    StatusLines,
    alarm_changes,
    held_words,
    refused,
    transition,
    unanswered,
    unread_e_stop,
    word_of,
)

__all__ = [
    "PROGRAMS",
    "Answer",
    "Controller",
    "ControllerSnapshot",
    "GripLastWill",
    "Status",
    "StatusLines",
    "StepReport",
    "alarm_changes",
    "changer_will",
    "ending_in_words",
    "held_words",
    "maintenance_will",
    "model_constants",
    "network_of",
    "refused",
    "told_to_grip",
    "transition",
    "unanswered",
    "unread_e_stop",
    "word_of",
]
