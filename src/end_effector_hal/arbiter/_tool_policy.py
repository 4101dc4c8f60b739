"""The output lines of a tool: the program that writes each line, and the interlocks that the arbiter enforces."""

from __future__ import annotations

from zlib import crc32

from end_effector_hal.arbiter.rules._coils import SecondCoil
from end_effector_hal.arbiter.rules._policy import Exclusion, Need, Policy, Role
from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.sensing import (
    E_STOP_CLOSED,
    LOCKED,
    NO_FAULT,
    NO_LATCHED_FAULT,
    NOTHING_GRIPPED,
    PARKED,
    PRESENT,
    predicates_fitted,
    proven_by_arbiter,
)
from end_effector_hal.vocabulary import printable, to_us

LONGEST_LAST_WILL_US = 10_000_000
HAL, OUTPUTS = "hal", "outputs"
"""Names of the clients: the program of the tool, and that of its plain outputs."""
SENSOR_FAULT = "sensor_fault"
"""Name under which the line arbiter latches the sensor fault of the tool changer (IL-04)."""
IL_01 = Need(
    NOTHING_GRIPPED, "IL-01", "nothing is gripped", "the sensors do not prove that nothing is gripped"
)
IL_02 = Need(PARKED, "IL-02", "the tool is in its stand", "the tool is neither in its stand nor absent")
IL_05 = Need(LOCKED, "IL-05", "the tool is locked", "the tool is not proven to be locked")
IL_05_PRESENT = Need(PRESENT, "IL-05", "the tool is present", "the sensor shows no tool")
IL_13 = Need(
    E_STOP_CLOSED, "IL-13", "the emergency stop is closed", "the emergency stop is open",
    latched="the emergency stop was opened",
)  # fmt: skip


def arbiter_policy(description: Description) -> Policy:
    """Return the output interlocks of a tool."""
    changer = description.tool_changer
    labels = {actuator.line: name for name, actuator in description.ordered}
    labels |= {
        line: f"{kind_of(description.actuators[name]).opposing.replace('_', '-')} of {name}"
        for name, line in description.blow_off_lines.items()
    }
    labels |= {each.line: name for name, each in description.outputs.items()}
    labels |= {changer.line: "unlock"} if changer else {}
    return Policy(
        description.output_lines,
        exclusions=_exclusions(description),
        max_active_us=_longest(description),
        labels=labels,
        roles={line: _role(description, line, label) for line, label in labels.items()},
        longest_last_will_us=max(
            LONGEST_LAST_WILL_US, sum(to_us(actuator.release_s) for _, actuator in description.ordered)
        ),
        faults={SENSOR_FAULT: HAL} if changer else {},
        opposites={
            line: SecondCoil(each.line, to_us(each.pulse_s or 0), to_us(each.pause_s or 0))
            for line, each in description.opposites.items()
        },
        release_us=description.release_us,
        registers={
            line: len(each.command_on)
            for line, each in description.register_outputs.items()
            if each.register_type == "holding" and each.bitmask is None
        },
        proven=proven_by_arbiter(description, carrier_of(description)),
        needs={line: needs for line in description.output_lines if (needs := _needs(description, line))},
    )


def _role(description: Description, line: str, label: str) -> Role:
    """Describe what a line drives, how, and on which chip or bus, for an arbiter with another description."""
    kinds = {actuator.line: f" ({actuator.kind})" for actuator in description.actuators.values()}
    words, coil = label + kinds.get(line, ""), description.opposites.get(line)
    if coil:
        words += f" with {'pulses and ' if coil.pulse_s else ''}the second coil {coil.line}"
    bus = next((name for name, outputs in description.buses.items() if line in outputs), None)
    if bus is not None:
        settings = crc32(description.register_outputs[line].model_dump_json().encode())
        words += f" on {description.links[bus].port}, register settings {settings:08x}"
    elif description.lines.path:
        words += f" on {description.lines.path}"
    return Role(printable(words), line in description.may_be_unknown)


def _longest(description: Description) -> dict[str, int]:
    """Return the longest unlock (IL-03) and blow-off; the arbiter ends them even if the program does not."""
    changer = description.tool_changer
    longest = {each.line: each.most_ms * 1000 for each in description.blow_offs.values()}
    return longest | ({changer.line: to_us(changer.unlock_max_s)} if changer and not changer.latching else {})


def _exclusions(description: Description) -> list[Exclusion]:
    """Return the lines that exclude each other: unlock and gripping (IL-01, IL-05), opposed outputs (IL-08)."""
    changer, never = description.tool_changer, list[Exclusion]()
    if changer and description.interlocks.il_01:
        gripping = [line for line in client_lines(description, HAL) if line != changer.line]
        never += [Exclusion(changer.line, line) for line in gripping]
    for _, actuator in description.ordered:
        if output := kind_of(actuator).opposing_output(actuator):
            never.append(Exclusion(actuator.line, output.line, "IL-08", "IL-08", to_us(output.gap_s)))
    return never


def _needs(description: Description, line: str) -> list[Need]:
    """Return what the fitted sensors must prove before a line is activated."""
    fitted = predicates_fitted(description, carrier_of(description))
    locks = description.interlocks
    unlocks = description.tool_changer is not None and line == description.tool_changer.line
    grips = any(line == actuator.line for _, actuator in description.ordered)
    asked = [
        (IL_01, unlocks and locks.il_01),
        (IL_02, unlocks and locks.il_02),
        (IL_05, grips and locks.il_05),
        (IL_05_PRESENT, grips and locks.il_05),
        (IL_13, True),
    ]
    asked += [(_no_fault(predicate), grips) for predicate in sorted(fitted) if ":" in predicate]
    return [need for need, wanted in asked if wanted and need.predicate in fitted]


def _no_fault(predicate: str) -> Need:
    """Require that a device has no fault, by the channel that shows the fault (IL-07)."""
    channel = predicate.removeprefix(NO_FAULT).removeprefix(NO_LATCHED_FAULT)
    latched = f"{channel} has shown a fault" if predicate.startswith(NO_LATCHED_FAULT) else ""
    return Need(predicate, "IL-07", f"{channel} shows no fault", f"{channel} shows a fault", latched)


def client_lines(description: Description, client: str) -> tuple[str, ...]:
    """Return the lines that ``hal`` or ``outputs`` writes."""
    if client == OUTPUTS:
        return tuple(each.line for each in description.outputs.values())
    changer = description.tool_changer
    gripping = tuple(actuator.line for _, actuator in description.ordered)
    blown = tuple(each.line for each in description.blow_offs.values())
    return (*gripping, *([changer.line] if changer else ()), *blown)
