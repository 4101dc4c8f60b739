"""What the line arbiter does when a program dies: computed here, so that the owner knows no gripping logic."""

from __future__ import annotations

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWillStep, to_us

from ._status import Status


def will_of(
    description: Description, status: Status, *, on: str = "process_death"
) -> tuple[LastWillStep, ...]:
    """Deactivations in release order of what is engaged now and is declared to be released; empty: hold.

    Held, or left active by an unwinding: it stays, unless the description says otherwise (IL-09). Before GRIPPED:
    as it says; while releasing: the release is carried out. The owner sees no sensors, so it gives each step the whole
    time that the release allows it.

    Args:
        description: the tool.
        status: its state when the will is written.
        on: ``process_death`` or ``sigterm``, the ending that it is for.
    """
    steps: list[LastWillStep] = []
    after_us = 0
    for name in description.releasing:
        index = description.sequence.index(name)
        if status.outputs[index] and not _stays(description, status, name, on, left=index in status.kept):
            actuator = description.actuators[name]
            steps.append(LastWillStep(actuator.line, after_us=after_us))
            after_us += to_us(actuator.release_s)
    return tuple(steps)


def _stays(description: Description, status: Status, name: str, on: str, *, left: bool) -> bool:
    endings = description.endings_of(name)
    if status.held or left:
        return bool(getattr(endings.held, on) != "release")
    return status.ee != EndEffectorState.RELEASING and bool(getattr(endings.gripping, on) != "release")
