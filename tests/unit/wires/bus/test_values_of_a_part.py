"""The registers that make an output grip depend on the part: those of an earlier part are never written again."""

from __future__ import annotations

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.wires.bus._outputs import BusOutputs

FINGERS, AT = "modbus:9/0x03E8", 1_000_000
OUTPUT = RegisterOutput(unit=9, address=0x03E8, command_on=(1, 255), command_off=(1, 0))


def written(outputs: BusOutputs, level: bool, at: int) -> tuple[int, ...]:
    outputs.command({FINGERS: level}, at)
    write = outputs.next_write(at)
    assert write is not None
    outputs.sent(write)
    outputs.acknowledged(at)
    return tuple(write.values)


def test_an_activation_writes_the_values_that_came_with_it() -> None:
    outputs = BusOutputs({FINGERS: OUTPUT}, fresh_us=100_000)
    outputs.prepare([], {FINGERS: (1, 180)})
    assert written(outputs, True, AT) == (1, 180)
    assert written(outputs, False, AT + 1_000_000) == (1, 0)
    assert written(outputs, True, AT + 2_000_000) == (1, 255), (
        "maintenance, or a tool that names no parts any more"
    )


def test_one_part_with_its_own_values_sends_them_too() -> None:
    fingers = {"kind": "gripper", "part_bit": "part", "modbus": OUTPUT.model_dump()}
    shipped = load(profile_path())
    gripper = type(shipped).model_validate(
        {
            "name": "one",
            "sequence": ["fingers"],
            "actuators": {"fingers": fingers},
            "parts": {"crate": {"actuators": {"fingers": {"modbus": {"command_on": (1, 180)}}}}},
        }
    )
    assert isinstance(gripper, Description)
    assert gripper.part_outputs == {gripper.actuators["fingers"].line}
    assert gripper.for_part("").register_outputs[FINGERS].command_on == (1, 180)
