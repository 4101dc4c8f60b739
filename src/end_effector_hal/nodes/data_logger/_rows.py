"""What a message means in the rows of a recording: live, and when a bag is imported."""

from __future__ import annotations

from end_effector_hal.nodes.transport import FrameMessage, StateMessage
from end_effector_hal.recording import Recording
from end_effector_hal.vocabulary import received_alarms


def write_state(recording: Recording, message: StateMessage) -> None:
    """Raises ReportedError when it cannot be written now."""
    recording.state(message.at_us, message.state, message.command, message.actuators)
    recording.tool_changer(message.at_us, message.tool_changer)
    recording.alarms(message.at_us, received_alarms(message.alarms, message.alarm_ids))


def write_frame(recording: Recording, message: FrameMessage) -> None:
    """Raises ReportedError when it cannot be written now."""
    values = {
        channel: value if valid else None
        for channel, value, valid in zip(message.channels, message.values, message.valid, strict=False)
    }
    recording.values(message.at_us, values)
