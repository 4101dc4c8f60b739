"""An electric gripper that powers up with its error bit set: a Drop gets it out, and nothing before that."""

from __future__ import annotations

import pytest

from tests.unit.wires.bus.played_bus import MS, Bus, S, described

TOOL = """
schema: 2
name: electric
link: {{port: /dev/ttyUSB0, baudrate: 115200, frame: {{modbus: {{}}}}}}
channels:
  ready: {{modbus: {{unit: 5, address: 32, bitmask: 0x1}}, on: [1]}}
  closing: {{modbus: {{unit: 5, address: 32, bitmask: 0x2}}, on: [1]}}
  opened: {{modbus: {{unit: 5, address: 32, bitmask: 0x4}}, on: [1]}}
  part: {{modbus: {{unit: 5, address: 32, bitmask: 0x8}}, on: [1]}}
sequence: [jaws]
actuators:
  jaws: {{kind: gripper, part_bit: part, open_bit: opened, timeout_s: 9, release_s: 9, modbus: {{
    unit: 5, address: 0, command_on: [0x11], command_off: [0x21]{more}}}}}
supply: {{channel: none}}
"""
ON, OFF, CLEAR, RISE = (0x11,), (0x21,), (0x04,), (0x01,)
VERIFY, ACKNOWLEDGE = ", verify: closing", ", acknowledge: [[0x04]]"
ACTIVATION = ", activation: {write: [[0], [1]], ready: ready, ready_within_s: 2}"


class Electric:
    """Bit 0 of its command enables it where it rises, bit 2 clears its error; in an error it obeys nothing."""

    def __init__(self, *, clears: bool, enables: bool) -> None:
        self.error, self.ready, self.is_open = True, not enables, False
        self.clears, self.enables = clears, enables
        self.word = 0
        self.written: list[tuple[int, ...]] = []

    def read(self, function: int, address: int, count: int, at: int) -> list[int]:
        return [int(self.ready and not self.error) | self.is_open << 2 for _ in range(count)]

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        self.written.append(values)
        (word,) = values
        rises = word & 1 and not self.word & 1
        self.word = word
        if word & 4 or (rises and not self.clears):
            self.error = False
        if rises and self.enables and not self.error:
            self.ready = True
        elif word & 0x20 and self.ready and not self.error:
            self.is_open = True
        return True


@pytest.mark.parametrize("verify", ["", VERIFY])
@pytest.mark.parametrize(
    ("keys", "written"),
    [
        (ACKNOWLEDGE, [CLEAR, OFF]),
        (ACTIVATION, [(0,), RISE, OFF]),
        (ACKNOWLEDGE + ACTIVATION, [CLEAR, (0,), RISE, OFF]),
    ],
    ids=["acknowledge", "activation", "both"],
)
def test_a_drop_clears_and_activates_it_as_described_and_then_opens_it(
    verify: str, keys: str, written: list[tuple[int, ...]]
) -> None:
    device = Electric(clears=ACKNOWLEDGE in keys, enables=ACTIVATION in keys)
    bus = Bus(described(TOOL.format(more=verify + keys)), {5: device})
    (name,) = bus.outputs.known(0) or ("modbus:5/0x0000",)
    bus.to(1 * S)
    assert device.written == []
    bus.outputs.prepare([name], {})
    bus.outputs.command({name: False}, bus.at)
    bus.to(bus.at + 2 * S)
    assert device.written == written
    assert device.is_open
    assert bus.outputs.known(bus.at) == {name: False}


def test_a_release_that_is_no_drop_waits_and_a_reset_clears_without_activating() -> None:
    device = Electric(clears=True, enables=True)
    bus = Bus(described(TOOL.format(more=VERIFY + ACKNOWLEDGE + ACTIVATION)), {5: device})
    bus.to(100 * MS)
    bus.outputs.command({"modbus:5/0x0000": False}, bus.at)
    bus.to(bus.at + 5 * S)
    assert device.written == []
    bus.outputs.acknowledge(bus.at)
    bus.to(bus.at + 5 * S)
    assert device.written == [CLEAR]
