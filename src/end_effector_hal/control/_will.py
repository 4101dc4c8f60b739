"""What the line owner does when a program dies: computed here, so that the owner knows no gripping logic."""

from __future__ import annotations

from end_effector_hal.description import Description, Ending
from end_effector_hal.trace import EndEffectorState
from end_effector_hal.wires.will import WillStep

from ._status import Status
from ._time import to_us


def will_of(description: Description, status: Status, *, on: str = "process_death") -> tuple[WillStep, ...]:
    """Deactivations in release order of what is engaged now; empty: hold.

    Held: nothing, unless the description says otherwise (IL-09). Before GRIPPED, and while releasing: unwind;
    the owner sees no sensors, so it gives each step the whole time that the release allows it.

    Args:
        description: the tool.
        status: its state when the will is written.
        on: ``process_death`` or ``sigterm``, the ending that it is for.
    """
    ending: Ending = getattr(description.endings.held if status.held else description.endings.gripping, on)
    if status.ee == EndEffectorState.RELEASING:
        ending = "release"
    if ending == "hold":
        return ()
    steps: list[WillStep] = []
    after_us = 0
    for name in description.releasing:
        if status.outputs[description.sequence.index(name)]:
            actuator = description.actuators[name]
            steps.append(WillStep(actuator.line, after_us=after_us))
            after_us += to_us(actuator.release_s)
    return tuple(steps)
