"""A bus with outputs in virtual time, and the devices at its far end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from end_effector_hal.codecs import codec_of
from end_effector_hal.codecs.modbus import ModbusMaster, cycle_record
from end_effector_hal.description import Description, examine_text
from end_effector_hal.signals import Frame
from end_effector_hal.wires.bus import BusOutputs, BusTraffic, fresh_for_us
from tests.support.rtu_server import RegisterMap, RtuServer

MS, S = 1_000, 1_000_000
EXAMPLES = Path(__file__).parents[4] / "examples" / "tools"
FINGERS = "modbus:9/0x03E8"
ANSWER_US = 2 * MS

VG10 = """
schema: 2
name: cups
link: {port: /dev/ttyUSB0, baudrate: 115200, parity: E, frame: {modbus: {}}}
channels:
  a_vacuum: {modbus: {unit: 65, address: 18}, unit: kPa, scale: -0.1}
  b_vacuum: {modbus: {unit: 65, address: 19}, unit: kPa, scale: -0.1}
  a_grips: {modbus: {unit: 65, address: 0, bitmask: 0xFF00}, on: [1]}
  b_grips: {modbus: {unit: 65, address: 1, bitmask: 0xFF00}, on: [1]}
sequence: [a, b]
actuators:
  a:
    {kind: vacuum, channel: a_vacuum,
     modbus: {unit: 65, address: 0, command_on: [0x0150], command_off: [0x0000], verify: a_grips}}
  b:
    {kind: vacuum, channel: b_vacuum,
     modbus: {unit: 65, address: 1, command_on: [0x0150], command_off: [0x0000], verify: b_grips}}
supply: {channel: none}
"""

TWO_UNITS = """
schema: 2
name: units
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {timeout_ms: 200}}, period_ms: 100}
channels:
  one: {modbus: {unit: 3, address: 18}, unit: kPa, scale: -0.1}
  two: {modbus: {unit: 3, address: 19}, unit: kPa, scale: -0.1}
  three: {modbus: {unit: 3, address: 20}, unit: kPa, scale: -0.1}
sequence: [a, b, c]
actuators:
  a: {kind: vacuum, channel: one, modbus: {unit: 1, address: 0, command_on: [1], command_off: [0]}}
  b: {kind: vacuum, channel: two, modbus: {unit: 1, address: 10, command_on: [1], command_off: [0]}}
  c: {kind: vacuum, channel: three, modbus: {unit: 3, address: 0, command_on: [1], command_off: [0]}}
supply: {channel: none}
"""


def described(text: str) -> Description:
    found = examine_text(text, "cups.yaml")
    assert found.description, found.lines()
    return found.description


def example(name: str) -> Description:
    return described((EXAMPLES / name / "end_effector.yaml").read_text())


class Registers:
    """Plain ones, by address; what was written in one request stands in ``written``."""

    def __init__(self) -> None:
        self.words = dict.fromkeys(range(64), 0)
        self.written: list[tuple[int, tuple[int, ...]]] = []

    def read(self, function: int, address: int, count: int, at: int) -> list[int]:
        return [self.words[address + i] for i in range(count)]

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        self.written.append((address, values))
        self.words |= {address + i: value for i, value in enumerate(values)}
        return True


class Bus:
    """The master, a wire, and the devices; ``wire`` changes an answer on its way, or loses it."""

    def __init__(self, tool: Description, units: dict[int, RegisterMap], at: int = 0) -> None:
        self.codec, self.at = codec_of(tool), at
        period_us = self.codec.period_us
        self.outputs = BusOutputs(tool.register_outputs, fresh_for_us(period_us), tool.release_us)
        self.server = RtuServer(units)
        self.wire: Callable[[bytes, bytes], bytes] = lambda request, answer: answer
        self.requests: list[bytes] = []
        self.frames: list[Frame] = []
        self.records: list[bytes] = []
        self.power()

    def power(self) -> None:
        """The port is opened, anew."""
        master = self.codec.decoder()
        assert isinstance(master, ModbusMaster)
        self.outputs.reopened(self.at)
        self.traffic = BusTraffic(master, self.outputs)
        self.arriving: list[tuple[int, bytes]] = []

    def to(self, until: int) -> None:
        while True:
            due = min([self.traffic.due, *(when for when, _ in self.arriving)])
            if due > until:
                break
            self.at = max(self.at, due)
            if self.arriving and self.arriving[0][0] <= self.at:
                cycles = [self.traffic.feed(self.arriving.pop(0)[1], self.at)]
            else:
                cycles = []
            request, cycle = self.traffic.poll(self.at)
            for each in (*cycles, cycle):
                if each is not None:
                    self.records.append(cycle_record(each.answers, each.at, each.inactive))
                    self.frames += [each.frame] if each.frame else []
            if request:
                self.requests.append(request)
                answer = self.wire(request, self.server.answer(request, self.at))
                if answer:
                    self.arriving.append((self.at + ANSWER_US, answer))
        self.at = until
        self.outputs.advance(self.at)

    def command(self, level: bool) -> None:
        self.outputs.command({FINGERS: level}, self.at)


def writes(request: bytes) -> bool:
    return request[1] in (5, 6, 15, 16)
