"""The decisions of the tool: its executed automata and the texts about them; no I/O."""

from ._automata import load_automata
from ._constants import model_constants
from ._controller import Controller, ControllerSnapshot, Foreseen
from ._events import COMMANDS, FAILURES, EventKind, EventReader, ToolEvent, restart_events
from ._last_wills import GripLastWill, changer_will, ending_in_words, maintenance_will
from ._network import network_of
from ._status import Answer, Status, StepReport, unknown_now
from .words import (
    event_line,
    event_lines,
    event_text,
    held_words,
    refused,
    unanswered,
    unread_e_stop,
    word_of,
)

__all__ = [
    "COMMANDS",
    "FAILURES",
    "Answer",
    "Controller",
    "ControllerSnapshot",
    "EventKind",
    "EventReader",
    "Foreseen",
    "GripLastWill",
    "Status",
    "StepReport",
    "ToolEvent",
    "changer_will",
    "ending_in_words",
    "event_line",
    "event_lines",
    "event_text",
    "held_words",
    "load_automata",
    "maintenance_will",
    "model_constants",
    "network_of",
    "refused",
    "restart_events",
    "unanswered",
    "unknown_now",
    "unread_e_stop",
    "word_of",
]
