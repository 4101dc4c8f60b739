"""The output lines of a tool: who writes them, and what their owner enforces whoever asks."""

from __future__ import annotations

from end_effector_hal.control import E_STOP_CLOSED, LOCKED, NOTHING_GRIPPED, predicates_fitted, to_us
from end_effector_hal.description import Description
from end_effector_hal.wires import Need, Policy, get_codec

IL_01 = Need(
    NOTHING_GRIPPED, "IL-01", "nothing is gripped", "the sensors do not prove that nothing is gripped"
)
IL_05 = Need(LOCKED, "IL-05", "the tool is locked", "the tool is not proven to be locked")
IL_13 = Need(
    E_STOP_CLOSED, "IL-13", "the emergency stop is closed", "the emergency stop is open",
    latched="the emergency stop was opened",
)  # fmt: skip


def owner_policy(description: Description) -> Policy:
    """The output interlocks of a tool."""
    lines, changer = output_lines(description), description.tool_changer
    labels = {actuator.line: name for name, actuator in description.ordered}
    needs = {line: needed for line in lines if (needed := _needs(description, line))}
    if changer is None:
        return Policy(lines, labels=labels, needs=needs)
    gripping = program_lines(description, "grip")
    return Policy(
        lines,
        exclusions=[(changer.line, line) for line in gripping] if description.interlocks.il_01 else [],
        max_active_us={} if changer.latching else {changer.line: to_us(changer.unlock_max_s)},
        labels={**labels, changer.line: "unlock"},
        needs=needs,
    )


def _needs(description: Description, line: str) -> list[Need]:
    """What the sensors must say before a line is activated; what is not fitted is not asked for."""
    fitted = predicates_fitted(description, get_codec(description.link.codec))
    locks = description.interlocks
    unlocks = line in program_lines(description, "tool_change")
    asked = [(IL_01, unlocks and locks.il_01), (IL_05, not unlocks and locks.il_05), (IL_13, True)]
    return [need for need, wanted in asked if wanted and need.predicate in fitted]


def output_lines(description: Description) -> tuple[str, ...]:
    """Every output line of a tool, actuators in sequence order, then the tool changer."""
    lines = [actuator.line for _, actuator in description.ordered]
    return (*lines, description.tool_changer.line) if description.tool_changer else tuple(lines)


def program_lines(description: Description, program: str) -> tuple[str, ...]:
    """The lines that one program writes."""
    if program == "grip":
        return tuple(actuator.line for _, actuator in description.ordered)
    return (description.tool_changer.line,) if description.tool_changer else ()
