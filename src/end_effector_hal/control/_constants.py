"""The constants of the model, computed from a description: the only place where the two meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import LEASE_US

Constants = dict[str, "int | Sequence[int] | Sequence[Sequence[int]]"]


def model_constants(description: Description) -> Constants:
    """Return the constants by their name in the UPPAAL file; times in ms.

    Interlocks whose sensors the codec does not carry are off: they are not fitted.
    """
    carried = carrier_of(description).channels
    actuators = [actuator for _, actuator in description.ordered]
    parts = [[actuator for _, actuator in each.ordered] for each in description.per_part]
    changer, locks, bounds = description.tool_changer, description.interlocks, description.bounds
    required = description.durations
    fitted = changer is not None and changer.locked_bit in carried and changer.unlocked_bit in carried
    constants: Constants = {
        "N": len(actuators),
        "PARTS": len(parts),
        "USES": [list(description.uses(name)) for name in description.part_names],
        "ATTEMPTS": [[actuator.attempts for actuator in each] for each in parts],
        "T_CONFIRM": [[_ms(actuator.timeout_s) for actuator in each] for each in parts],
        "T_RESET": [_ms(actuator.reset_s) for actuator in actuators],
        "T_GONE": [_ms(actuator.release_s) for actuator in actuators],
        "RELEASE_ORDER": [description.sequence.index(name) for name in description.releasing],
        "D": bounds.reaction_ms,
        "SENSOR_GAP": bounds.sensor_gap_ms,
        "COMMAND_GAP": bounds.command_gap_ms,
        "GRIP_BOUND": required.grip_ms,
        "RELEASE_BOUND": required.release_ms,
        "CANCEL_BOUND": required.cancel_ms,
        "LEASE": LEASE_US // 1000,
        "CHANGER": changer is not None,
        "IL_01": locks.il_01,
        "IL_02": locks.il_02,
        "IL_05": locks.il_05 and fitted,
        "IL_06": locks.il_06 and description.supply.channel in carried,
        "IL_07": locks.il_07,
        "SHOWS_EMPTY": any(_shows_empty(actuator, carried) for each in parts for actuator in each),
        **_blow_offs(description),
        **_endings(description),
    }
    if changer is not None:
        constants |= {
            "UNLOCK_KEEPS": changer.endings.process_death != "release",
            "LATCHING": changer.latching,
            "T_PROVE": _ms(changer.prove_s),
            "T_UNLOCK": _ms(changer.unlock_max_s),
            "T_ARM": _ms(changer.arm_s),
            "STAND": changer.stand_bit in carried,
            "PRESENCE": locks.il_05 and changer.present_bit in carried,
        }
    return constants


def _blow_offs(description: Description) -> Constants:
    """Return the constants for the blow-off of each part during a release."""
    times = description.blow_offs
    driven = [times.get(name) for name in description.sequence]
    return {
        "BLOWS": bool(times),
        "T_BLOW": [each.blow_ms if each else 0 for each in driven],
        "T_GAP": [each.rest_ms if each else 0 for each in driven],
        "IL_08_GAP": [each.gap_ms if each else 0 for each in driven],
        "UNTIL_GONE": [each.until_gone if each else False for each in driven],
    }


def _endings(description: Description) -> Constants:
    """Return for each ending of the automata which outputs stay active."""
    each = [description.endings_of(name) for name in description.sequence]
    keeps: dict[str, list[int]] = {
        "CANCEL_KEEPS": [its.gripping.cancel != "release" for its in each],
        "TIMEOUT_KEEPS": [its.gripping.timeout != "release" for its in each],
        "ABORT_KEEPS": [its.gripping.abort != "release" for its in each],
        "LOSS_KEEPS": [its.held.lost != "release" for its in each],
        "START_KEEPS": [its.power_up != "release" for its in each],
        "DEATH_KEEPS": [its.gripping.process_death != "release" for its in each],
        "HELD_DEATH_KEEPS": [its.held.process_death != "release" for its in each],
    }
    return {**keeps, "MIXED": any(len(set(some)) > 1 for some in keeps.values())}


def _shows_empty(actuator: Actuator, carried: Mapping[str, Kind]) -> bool:
    conditions = kind_of(actuator).conditions(actuator)
    empty = conditions.empty if conditions else None
    return empty is not None and empty.can_be_known(carried)


def _ms(seconds: float) -> int:
    return round(seconds * 1000)
