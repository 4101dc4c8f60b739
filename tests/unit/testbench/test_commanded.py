"""The registers that a description commands: a device that hears nothing for its time lets go, if it is said to."""

from __future__ import annotations

from end_effector_hal.codecs import codec_of, load_tool
from end_effector_hal.codecs.modbus import ModbusMaster, RegisterWrite, write_request
from end_effector_lab.testbench import CommandedRegisters
from tests.support.places import ROOT

EPICK = load_tool(ROOT / "examples/tools/epick_commanded/end_effector.yaml")
((NAME, OUTPUT),) = EPICK.register_outputs.items()
MASTER = codec_of(EPICK, "").decoder()
assert isinstance(MASTER, ModbusMaster)
READ = MASTER.poll(0).data
S = 1_000_000


def commanded(**changed: object) -> tuple[CommandedRegisters, list[tuple[str, bool]]]:
    obeyed: list[tuple[str, bool]] = []
    output = OUTPUT.model_copy(update=changed)
    registers = CommandedRegisters({NAME: output}, lambda name, level: obeyed.append((name, level)))
    registers.start({NAME: True}, 0)
    return registers, obeyed


def test_an_activation_with_an_address_of_its_own_is_one() -> None:
    activation = OUTPUT.activation
    assert activation
    activation = activation.model_copy(update={"address": 0x0100})
    registers, obeyed = commanded(activation=activation)
    registers.start({}, 0)
    on = write_request(RegisterWrite(OUTPUT.unit, OUTPUT.address, OUTPUT.command_on))
    registers.answer(on)
    assert obeyed == [], "it is not activated"
    for row in activation.write:
        assert registers.answer(write_request(RegisterWrite(OUTPUT.unit, 0x0100, row)))
    registers.answer(on)
    assert obeyed == [(NAME, False), (NAME, True)], "an activation moves it"


def test_a_release_whose_activation_bit_rises_activates_a_device_that_lost_its_power() -> None:
    registers, obeyed = commanded()
    registers.start({}, 0)
    registers.answer(write_request(RegisterWrite(OUTPUT.unit, OUTPUT.address, OUTPUT.command_off)))
    assert registers.values["activated"] is True
    assert obeyed == [(NAME, False)] * 2


def test_what_is_heard_keeps_it_alive() -> None:
    registers, obeyed = commanded()
    for at in range(0, 5 * S, S // 2):
        registers.hear(READ, at)
        registers.advance(at)
    assert obeyed == []
    assert registers.due == 4 * S + S // 2 + S
    registers.advance(registers.due - 1)
    assert obeyed == []
    registers.advance(registers.due)
    assert obeyed == [(NAME, False)]
    assert registers.due is None
    assert registers.values["told_to_grip"] is False


def test_a_request_to_another_unit_is_not_heard() -> None:
    registers, obeyed = commanded()
    registers.hear(write_request(RegisterWrite(8, OUTPUT.address, OUTPUT.command_on)), S // 2)
    registers.advance(S)
    assert obeyed == [(NAME, False)]


def test_what_holds_without_a_link_or_has_no_time_stays() -> None:
    for changed in ({"on_link_loss": "hold"}, {"on_link_loss": "undefined"}, {"keep_alive_ms": None}):
        registers, obeyed = commanded(**changed)
        assert registers.due is None
        registers.advance(3600 * S)
        assert obeyed == []
