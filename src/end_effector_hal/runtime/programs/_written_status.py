"""Complete a status of the controller with what was really written to the lines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from end_effector_hal.control import EventKind, Status
from end_effector_hal.description import Description
from end_effector_hal.runtime.outputs import Maintenance

from ._adoption import Adoption


def with_reasons(status: Status, why: str, refused: Mapping[bool, str]) -> Status:
    """Return a status with the reasons of the program.

    Args:
        status: of the controller.
        why: why the program has restarted, a sentence; empty: it has not.
        refused: see `Outputs.refused`.
    """
    reason = f"{status.reason or why} {refused[False]}".strip()
    changer_reason = f"{status.changer_reason or why} {refused[True]}".strip()
    if (reason, changer_reason) == (status.reason, status.changer_reason):
        return status
    return replace(status, reason=reason, changer_reason=changer_reason)


def as_written(
    status: Status, description: Description, adoption: Adoption, maintenance: Maintenance, *, held: bool
) -> Status:
    """Return a status with the levels that the lines have, as far as the program knows them.

    Args:
        status: of the controller.
        description: the tool.
        adoption: what was written.
        maintenance: what it has activated.
        held: whether a part was held before a restart.
    """
    outputs = adoption.outputs
    if status.blowing and outputs.refused[False]:
        status = _without_air(status, description, outputs.activated)
    if adoption.lost or adoption.alarm:  # as last known; what was never known is in doubt active
        known, begun = outputs.known, adoption.begun
        levels = _levels(status, description, lambda line, level: known.get(line, level or not begun))
        unlock = known.get(outputs.mapping.unlock_line, status.unlock_output)
        held = status.held if begun else held
        status = replace(status, outputs=levels, held=held, unlock_output=unlock)
    if not maintenance.lines:
        return status
    levels = _levels(status, description, lambda line, level: level or line in maintenance.lines)
    return replace(status, outputs=levels, deadline=maintenance.ends_at, maintenance=True)


def _without_air(status: Status, description: Description, activated: frozenset[str]) -> Status:
    """Return a status without the blow-offs that the line arbiter has refused."""
    air, names = description.blow_off_lines, description.sequence
    blown = tuple(each for each in status.blowing if air[names[each]] in activated)
    events = tuple(
        event for event in status.events if event.kind is not EventKind.BLOWN_OFF or event.actuator in blown
    )
    return replace(status, blowing=blown, events=events)


def _levels(
    status: Status, description: Description, level_of: Callable[[str, bool], bool]
) -> tuple[bool, ...]:
    pairs = zip(description.ordered, status.outputs, strict=True)
    return tuple(level_of(actuator.line, level) for (_, actuator), level in pairs)
