"""What the nodes and a ROS generation agree upon: the protocol, the messages, and which of them are accepted."""

from ._frames import AMBIENT_PA, absolute_pa, frame_from_message, frame_to_message
from ._messages import (
    CommandMessage,
    DiagnosticMessage,
    DiagnosticsMessage,
    FrameMessage,
    KeyValueMessage,
    MessageHeader,
    PositionMessage,
    PressureMessage,
    StateMessage,
    StatusMessage,
    StepMessage,
)
from ._places import ChangerPlace, CylinderPlace
from ._stamp_check import StampCheck
from ._transport import CommandClient, GoalClient, GoalService, NodeTransport
from ._unknown_senders import UnknownSenders

__all__ = [
    "AMBIENT_PA",
    "ChangerPlace",
    "CommandClient",
    "CommandMessage",
    "CylinderPlace",
    "DiagnosticMessage",
    "DiagnosticsMessage",
    "FrameMessage",
    "GoalClient",
    "GoalService",
    "KeyValueMessage",
    "MessageHeader",
    "NodeTransport",
    "PositionMessage",
    "PressureMessage",
    "StampCheck",
    "StateMessage",
    "StatusMessage",
    "StepMessage",
    "UnknownSenders",
    "absolute_pa",
    "frame_from_message",
    "frame_to_message",
]
