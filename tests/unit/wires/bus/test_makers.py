"""Bytes that stand in makers' documents: what this master sends is what they print, and it reads what they say.

Documents, with the pages:

- Robotiq, "2F-85 & 2F-140 Instruction Manual", Modbus RTU example, p. 55 to 80; and "2-Finger Adaptive Robot Gripper -
  200 Instruction Manual", p. 60 (the status with function 03).
- Yuejiang Technology (Dobot), "PGE-2 Gripper User Manual", Issue V1.0 (2021-07-30), p. 11 to 16: a PGE of DH-Robotics.
- UFACTORY, "xArm Gripper User Manual", section 3.5.4, p. 29 and 30.
"""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import codec_of
from end_effector_hal.codecs.modbus import ModbusMaster
from end_effector_hal.signals import Value
from end_effector_hal.wires.bus import BusOutputs, BusTraffic, fresh_for_us
from tests.unit.wires.bus.played_bus import described

MS = 1_000
HEAD = """
schema: 2
name: maker
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {}}}
supply: {channel: none}
sequence: [jaws]
"""
ROBOTIQ = "unit: 9, address: 0x07D{}, register_type: input, bitmask: {}"


def read_tool(modbus: str, rest: str) -> str:
    return f"""{HEAD}
channels: {{bit: {{modbus: {{{modbus}}}, {rest}}}}}
actuators: {{jaws: {{kind: gripper, line: A, part_bit: bit}}}}
"""


@pytest.mark.parametrize(
    ("modbus", "rest", "request_", "answer", "value"),
    [
        pytest.param(
            "unit: 9, address: 0x07D0, register_type: input, bitmask: 0x3000", "on: [3]",
            "09 04 07 D0 00 01 30 0F", "09 04 02 11 00 54 A1", False, id="2F: its activation is not completed",
        ),
        pytest.param(
            "unit: 9, address: 0x07D0, register_type: input, bitmask: 0x3000", "on: [3]",
            "09 04 07 D0 00 01 30 0F", "09 04 02 31 00 4D 61", True, id="2F: its activation is completed",
        ),
        pytest.param(
            "unit: 1, address: 0x0200", "on: [1]",
            "01 03 02 00 00 01 85 B2", "01 03 02 00 00 B8 44", False, id="PGE: not initialized",
        ),
        pytest.param(
            "unit: 1, address: 0x0201", "on: [2]",
            "01 03 02 01 00 01 D4 72", "01 03 02 00 02 39 85", True, id="PGE: object caught",
        ),
    ],
)  # fmt: skip
def test_a_status_is_asked_and_read_as_the_maker_prints_it(
    modbus: str, rest: str, request_: str, answer: str, value: Value
) -> None:
    master = codec_of(described(read_tool(modbus, rest)), "").decoder()
    assert isinstance(master, ModbusMaster)
    assert master.poll(0).data == bytes.fromhex(request_)
    (frame,) = master.feed(bytes.fromhex(answer), 5 * MS)
    assert frame.values["bit"] is value


THREE = f"""{HEAD}
channels:
  part: {{modbus: {{{ROBOTIQ.format(0, "0xC800")}}}, on: [0x11]}}
  told: {{modbus: {{{ROBOTIQ.format(1, "0x00FF")}}}, on: [0xFF]}}
  opened: {{modbus: {{{ROBOTIQ.format(2, "0xFF00")}}}, on: [9, 10, 11, 12, 13]}}
actuators: {{jaws: {{kind: gripper, line: A, part_bit: part, open_bit: opened}}}}
"""


@pytest.mark.parametrize(
    ("answer", "part", "told", "opened"),
    [
        ("09 04 06 B9 00 00 FF BD 00 5C 9A", True, True, False),
        ("09 04 06 F9 00 00 00 0D 00 17 AA", False, False, True),
    ],
    ids=["the grasp is completed", "the opening is completed"],
)
def test_the_three_registers_of_a_2f_say_what_its_manual_says(
    answer: str, part: bool, told: bool, opened: bool
) -> None:
    master = codec_of(described(THREE), "").decoder()
    assert isinstance(master, ModbusMaster)
    assert master.poll(0).data == bytes.fromhex("09 04 07 D0 00 03 B1 CE")
    (frame,) = master.feed(bytes.fromhex(answer), 5 * MS)
    assert frame.values == {"part": part, "told": told, "opened": opened}


def test_fingers_that_move_hold_nothing_yet_by_the_manual_of_the_200() -> None:
    older = codec_of(described(THREE.replace(", register_type: input", "")), "").decoder()
    assert isinstance(older, ModbusMaster)
    assert older.poll(0).data == bytes.fromhex("09 03 07 D0 00 03 04 0E")
    (frame,) = older.feed(bytes.fromhex("09 03 06 39 00 00 FF 0E 0A F7 8B"), 5 * MS)
    assert frame.values["part"] is False
    assert frame.values["told"] is True


def commanded(modbus: str) -> str:
    return f"""{HEAD}
channels:
  bit: {{modbus: {{unit: 7, address: 1}}, on: [1]}}
  ready: {{modbus: {{unit: 7, address: 2}}, on: [1]}}
actuators: {{jaws: {{kind: gripper, part_bit: bit, timeout_s: 9, modbus: {{{modbus}}}}}}}
"""


TWO_FINGERS = (
    "unit: 9, address: 0x03E8, command_on: [0x0900, 0x00FF, 0xFFFF], command_off: [0x0900, 0, 0xFFFF], "
    "activation: {write: [[0x0100, 0, 0]], ready: ready}"
)
PGE = (
    "unit: 1, address: 0x0103, command_on: [500], command_off: [1000], "
    "activation: {address: 0x0100, write: [[1]], ready: ready}"
)
XARM = (
    "unit: 8, address: 0x0303, use_write_multiple: true, command_on: [1500], command_off: [0x0100], "
    "activation: {address: 0x0100, write: [[1]], ready: ready}"
)
XARM_MODE = "unit: 8, address: 0x0101, use_write_multiple: true, command_on: [0], command_off: [1]"
DONE_BY_A_2F = "09 10 03 E8 00 03 01 30"


@pytest.mark.parametrize(
    ("modbus", "ready", "level", "request_", "answer"),
    [
        pytest.param(
            TWO_FINGERS, False, True,
            "09 10 03 E8 00 03 06 01 00 00 00 00 00 72 E1", DONE_BY_A_2F, id="2F: activate",
        ),
        pytest.param(
            TWO_FINGERS, True, True,
            "09 10 03 E8 00 03 06 09 00 00 FF FF FF 42 29", DONE_BY_A_2F, id="2F: close at full speed and force",
        ),
        pytest.param(
            TWO_FINGERS, True, False,
            "09 10 03 E8 00 03 06 09 00 00 00 FF FF 72 19", DONE_BY_A_2F, id="2F: open at full speed and force",
        ),
        pytest.param(
            PGE, False, True, "01 06 01 00 00 01 49 F6", "01 06 01 00 00 01 49 F6", id="PGE: initialize",
        ),
        pytest.param(
            PGE, True, True, "01 06 01 03 01 F4 78 21", "01 06 01 03 01 F4 78 21", id="PGE: half way",
        ),
        pytest.param(
            XARM_MODE, True, True,
            "08 10 01 01 00 01 02 00 00 DD 11", "08 10 01 01 00 01 51 6C", id="xArm: position mode",
        ),
        pytest.param(
            XARM, False, True,
            "08 10 01 00 00 01 02 00 01 1D 00", "08 10 01 00 00 01 00 AC", id="xArm: enable",
        ),
        pytest.param(
            XARM, True, True,
            "08 10 03 03 00 01 02 05 DC FD FA", "08 10 03 03 00 01 F1 14", id="xArm: speed",
        ),
    ],
)  # fmt: skip
def test_a_command_is_sent_as_the_maker_prints_it_and_its_answer_acknowledges_it(
    modbus: str, ready: bool, level: bool, request_: str, answer: str
) -> None:
    tool = described(commanded(modbus))
    (name,) = tool.register_outputs
    outputs = BusOutputs(tool.register_outputs, fresh_for_us(20 * MS))
    outputs.report({"ready": ready}, 0, 0)
    outputs.command({name: level}, 0)
    master = codec_of(tool, "").decoder()
    assert isinstance(master, ModbusMaster)
    traffic, at, sent = BusTraffic(master, outputs), 0, b""
    while not sent or sent[0] == 7:  # what the channels ask is of unit 7, and stays without an answer
        at += MS
        outputs.report({"ready": ready}, at, at)
        sent, _ = traffic.poll(at)
    assert sent == bytes.fromhex(request_)
    before = outputs.next_write(at)
    assert before is not None
    traffic.feed(bytes.fromhex(answer), at + 2 * MS)
    assert traffic.unacknowledged == 0
    assert outputs.next_write(at + 3 * MS) != before, "it is done"


def test_another_answer_acknowledges_nothing() -> None:
    tool = described(commanded(PGE))
    (name,) = tool.register_outputs
    outputs = BusOutputs(tool.register_outputs, fresh_for_us(20 * MS))
    outputs.command({name: False}, 0)
    master = codec_of(tool, "").decoder()
    assert isinstance(master, ModbusMaster)
    traffic, at, sent = BusTraffic(master, outputs), 0, b""
    while not sent or sent[0] == 7:
        at += MS
        sent, _ = traffic.poll(at)
    traffic.feed(bytes.fromhex("01 06 01 03 01 F4 78 21"), at + 2 * MS)  # half way, and "open" was asked for
    assert outputs.known(at + 3 * MS) == {}
