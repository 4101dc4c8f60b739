"""Convert messages to the rows of a recording, both live and when a bag is imported."""

from __future__ import annotations

from end_effector_hal.control import EventKind, ToolEvent
from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.transport import StateMessage
from end_effector_hal.recording import Recording, event_row
from end_effector_hal.vocabulary import Cause, received_alarms


def write_state(recording: Recording, message: StateMessage) -> None:
    """Write the rows of a state message; raises ReportedError when they cannot be written now."""
    recording.state(message.at_us, message.state, message.command, message.actuators)
    recording.tool_changer(message.at_us, message.tool_changer)
    recording.alarms(message.at_us, received_alarms(message.alarms, message.alarm_ids))
    try:
        events = events_of(message)
    except ValueError as error:
        raise UsageError(f"The state message contains an invalid event: {error}.") from None
    recording.events(message.at_us, events)
    recording.part(message.at_us, message.part)


def events_of(message: StateMessage) -> list[ToolEvent]:
    """Return the events that a state message carries; raises ValueError for an invalid event."""
    names = ("", *message.actuator_names)
    found: list[ToolEvent] = []
    for each in message.events:
        kind, place, cause = EventKind(each.event), names.index(each.actuator) - 1, Cause(each.cause)
        states = each.old_state, each.new_state
        found.append(ToolEvent(each.at_us, kind, place, each.attempt, *states, cause, each.command))
        event_row(found[-1], 0.0, names[1:])
    return found
