"""A device that takes what is written by a handshake: in time, late, never, and without an end."""

from __future__ import annotations

import pytest

from end_effector_hal.description import Description
from end_effector_hal.wires.bus import BusOutputs, fresh_for_us
from tests.support.handshake_gripper import HandshakeGripper
from tests.unit.wires.bus.played_bus import ANSWER_US, MS, Bus, S, described

JAWS = "modbus:1/0x0000"
ON, OFF = (0x0200, 50), (0x0100, 50)
ASK, END, RESET = (0x0001, 50), (0x0000, 50), (0x8000, 0)

TOOL = """
schema: 2
name: jaws
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {}}}
channels:
  taken: {modbus: {address: 0x0100, bitmask: 0x1000}, on: [1]}
  part: {modbus: {address: 0x0100, bitmask: 0x0200}, on: [1]}
  opened: {modbus: {address: 0x0100, bitmask: 0x0100}, on: [1]}
  closed: {modbus: {address: 0x0100, bitmask: 0x0400}, on: [1]}
  fault: {modbus: {address: 0x0100, bitmask: 0x8000}, alarm: {text: the gripper has a fault}}
sequence: [jaws]
actuators:
  jaws:
    kind: gripper
    modbus:
      address: 0x0000
      command_on: [0x0200, 50]
      command_off: [0x0100, 50]
      handshake: {request: [1, 50], taken: taken, end: [0, 50], within_s: 0.4}
      acknowledge: [[0x8000, 0], [0x0000, 0]]
      on_link_loss: keep
    part_bit: part
    open_bit: opened
    closed_bit: closed
supply: {channel: none}
"""


@pytest.fixture(scope="module")
def tool() -> Description:
    return described(TOOL)


@pytest.fixture
def jaws() -> HandshakeGripper:
    return HandshakeGripper()


@pytest.fixture
def bus(tool: Description, jaws: HandshakeGripper) -> Bus:
    found = Bus(tool, {1: jaws})
    found.to(300 * MS)
    assert not jaws.written, "a start writes nothing"
    return found


def command(bus: Bus, level: bool) -> None:
    bus.outputs.command({JAWS: level}, bus.at)


def test_the_command_is_written_when_the_handshake_is_over(bus: Bus, jaws: HandshakeGripper) -> None:
    command(bus, True)
    bus.to(bus.at + 1 * S)
    assert jaws.written == [END, ASK, END, ON], "nobody knew whether one was open: it is ended first"
    assert jaws.holds(bus.at)
    assert bus.outputs.known(bus.at) == {JAWS: True}
    command(bus, False)
    bus.to(bus.at + 1 * S)
    assert jaws.written[4:] == [ASK, END, OFF]
    assert not jaws.closes
    assert not bus.outputs.troubles(bus.at)


def test_without_its_handshake_the_device_would_not_move(tool: Description, jaws: HandshakeGripper) -> None:
    bus = Bus(described(TOOL.replace("      handshake:", "      #")), {1: jaws})
    bus.to(300 * MS)
    command(bus, True)
    bus.to(bus.at + 2 * S)
    assert jaws.written == [ON]
    assert not jaws.closes


def test_until_the_device_has_taken_it_nobody_knows_how_it_stands(bus: Bus, jaws: HandshakeGripper) -> None:
    jaws.takes_us = 200 * MS
    command(bus, True)
    bus.to(bus.at + 180 * MS)
    assert bus.outputs.known(bus.at) == {}
    assert jaws.written[-1] == ASK
    bus.to(bus.at + 1 * S)
    assert bus.outputs.known(bus.at) == {JAWS: True}


def test_a_grip_that_is_never_taken_is_given_up_and_is_not_taken_later(
    bus: Bus, jaws: HandshakeGripper
) -> None:
    jaws.takes_us = None
    command(bus, True)
    bus.to(bus.at + 5 * S)
    assert bus.outputs.troubles(bus.at) == {
        JAWS: "was not activated: the device did not accept the command in time"
    }
    assert jaws.written[-1] == END, "or it would take later what was asked of it"
    told = len(jaws.written)
    jaws.takes_us = 0
    bus.to(bus.at + 20 * S)
    assert len(jaws.written) == told
    assert not jaws.closes
    command(bus, False)
    bus.to(bus.at + 1 * S)
    assert bus.outputs.known(bus.at) == {JAWS: False}


def test_a_handshake_that_does_not_end_gives_the_grip_up(bus: Bus, jaws: HandshakeGripper) -> None:
    command(bus, False)
    bus.to(bus.at + 1 * S)
    jaws.ends_us = None
    command(bus, True)
    bus.to(bus.at + 5 * S)
    why = "was not activated: the device did not end the handshake in time"
    assert bus.outputs.troubles(bus.at) == {JAWS: why}
    assert ON not in jaws.written


@pytest.mark.parametrize(("fault", "value"), [("takes_us", None), ("ends_us", None)])
def test_a_release_begins_its_handshake_again_until_the_device_answers_it(
    bus: Bus, jaws: HandshakeGripper, fault: str, value: object
) -> None:
    command(bus, True)
    bus.to(bus.at + 1 * S)
    right = getattr(jaws, fault)
    setattr(jaws, fault, value)
    command(bus, False)
    bus.to(bus.at + 10 * S)
    told = bus.outputs.troubles(bus.at)
    assert told[JAWS].startswith("is to be deactivated, and its device does not answer the handshake: ")
    assert bus.outputs.known(bus.at) == {}
    assert jaws.holds(bus.at)
    setattr(jaws, fault, right)
    bus.to(bus.at + 2 * S)
    assert bus.outputs.known(bus.at) == {JAWS: False}
    assert not jaws.closes


def test_a_release_in_the_middle_of_a_handshake_ends_that_first(bus: Bus, jaws: HandshakeGripper) -> None:
    jaws.takes_us = 200 * MS
    command(bus, True)
    while jaws.written[-1:] != [ASK]:
        bus.to(bus.at + 1 * MS)
    command(bus, False)
    bus.to(bus.at + 2 * S)
    assert jaws.written[-4:] == [END, ASK, END, OFF]
    assert ON not in jaws.written


def test_what_the_device_showed_before_a_write_is_no_answer_to_it(bus: Bus, jaws: HandshakeGripper) -> None:
    """It takes the data at once, and its bit goes late: a request that comes before that would not be seen."""
    command(bus, False)
    bus.to(bus.at + 1 * S)
    jaws.takes_us, jaws.ends_us = 0, 60 * MS
    jaws.written.clear()
    command(bus, True)
    while jaws.written[-1:] != [ASK]:
        bus.to(bus.at + 1 * MS)
    command(bus, False)  # no read has shown by now that it has taken them
    command(bus, True)
    bus.to(bus.at + 1 * S)
    assert jaws.written == [ASK, END, ASK, END, ON]
    assert jaws.closes
    assert not jaws.missed


def test_a_bit_that_is_on_before_it_is_asked_takes_nothing(bus: Bus, jaws: HandshakeGripper) -> None:
    """A device that was left in the middle of a handshake, by an arbiter before this one."""
    jaws.write(0, ASK, bus.at)
    bus.to(bus.at + 300 * MS)
    assert bus.frames[-1].values["taken"] is True
    jaws.written.clear()
    command(bus, True)
    bus.to(bus.at + 1 * S)
    assert jaws.written == [END, ASK, END, ON]


def test_an_e_stop_in_the_middle_of_a_handshake_moves_nothing(bus: Bus, jaws: HandshakeGripper) -> None:
    jaws.takes_us = 300 * MS
    command(bus, True)
    bus.to(bus.at + 200 * MS)
    bus.outputs.withdraw([JAWS], "IL-13: the e-stop is open")
    bus.to(bus.at + 5 * S)
    assert not jaws.closes
    assert jaws.written[-1] == END


def test_a_reset_clears_the_fault_of_a_device_that_holds_nothing(bus: Bus, jaws: HandshakeGripper) -> None:
    command(bus, False)
    bus.to(bus.at + 1 * S)
    jaws.error = True
    jaws.written.clear()
    bus.outputs.acknowledge(bus.at)
    bus.to(bus.at + 1 * S)
    assert not jaws.error
    assert jaws.written == [RESET, (0, 0), ASK, END, OFF]
    assert bus.outputs.known(bus.at) == {JAWS: False}


def test_a_reset_writes_nothing_to_a_device_that_may_hold(bus: Bus, jaws: HandshakeGripper) -> None:
    bus.outputs.acknowledge(bus.at)  # nobody has commanded it yet
    bus.to(bus.at + 1 * S)
    assert not jaws.written
    command(bus, True)
    bus.to(bus.at + 1 * S)
    told = list(jaws.written)
    jaws.error = True
    bus.outputs.acknowledge(bus.at)
    bus.to(bus.at + 1 * S)
    assert jaws.written == told
    assert jaws.holds(bus.at)


def test_a_release_that_a_fault_kept_back_is_done_after_the_reset(bus: Bus, jaws: HandshakeGripper) -> None:
    command(bus, True)
    bus.to(bus.at + 1 * S)
    jaws.error = True
    command(bus, False)
    bus.to(bus.at + 1 * S)
    assert jaws.holds(bus.at), "it does not obey while it has a fault"
    bus.outputs.acknowledge(bus.at)
    bus.to(bus.at + 1 * S)
    assert not jaws.closes


def test_after_the_command_a_handshake_has_the_device_take_it(jaws: HandshakeGripper) -> None:
    after = TOOL.replace("within_s: 0.4", "within_s: 0.4, order: after")
    bus = Bus(described(after), {1: jaws})
    bus.to(300 * MS)
    command(bus, True)
    bus.to(bus.at + 1 * S)
    assert jaws.written == [ON, END, ASK, END]


def test_of_an_adapter_that_loses_each_second_answer_the_handshake_survives(
    bus: Bus, jaws: HandshakeGripper
) -> None:
    lost = iter(range(10_000))
    bus.wire = lambda request, answer: b"" if next(lost) % 2 else answer
    command(bus, True)
    bus.to(bus.at + 3 * S)
    command(bus, False)
    bus.to(bus.at + 10 * S)
    assert not jaws.closes
    assert bus.outputs.known(bus.at) == {JAWS: False}


def test_a_bit_that_was_asked_for_before_a_write_is_no_answer_to_it_though_its_cycle_ends_later(
    tool: Description,
) -> None:
    outputs = BusOutputs(tool.register_outputs, fresh_for_us(20 * MS))
    outputs.command({JAWS: False}, 0)
    end = outputs.next_write(1 * MS)
    assert end is not None
    outputs.sent(end)
    outputs.acknowledged(10 * MS)
    outputs.report({"taken": False}, 20 * MS, asked_at=5 * MS)
    assert outputs.next_write(21 * MS) is None
    outputs.report({"taken": False}, 40 * MS, asked_at=30 * MS)
    ask = outputs.next_write(41 * MS)
    assert ask is not None
    assert ask.values == ASK


def test_a_cycle_of_several_reads_counts_from_its_first_one(
    jaws: HandshakeGripper, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = TOOL.replace("  part:", "  far: {modbus: {address: 0x0900}, on: [1]}\n  part:", 1)
    bus = Bus(described(text), {1: jaws})
    found: list[tuple[int, int]] = []
    monkeypatch.setattr(bus.outputs, "report", lambda values, at, asked_at: found.append((at, asked_at)))
    bus.to(1 * S)
    assert found
    assert all(at - asked_at >= 2 * ANSWER_US for at, asked_at in found)
