"""Bistable valves that are pulsed or held, and bits that are written alone: a server of pymodbus is the far end."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import cast

import pytest
from pymodbus.client import ModbusTcpClient

from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.codecs.modbus import BusCodec
from end_effector_hal.description import examine_text
from end_effector_hal.wires.bus import BusLink
from end_effector_hal.wires.bus._lines import BusLines
from tests.support.patience import wait_until
from tests.support.tcp_wire import Station

pytestmark = [pytest.mark.wall, pytest.mark.timeout(60)]
TOOL = """
schema: 2
name: valves
link: {port: "tcp://127.0.0.1:PORT", period_ms: 20, frame: {modbus: {timeout_ms: 200}}}
channels:
  one: {modbus: {address: 0, register_type: input}, unit: kPa}
  two: {modbus: {address: 1, register_type: input}, unit: kPa}
sequence: [a, b]
actuators:
  a:
    {kind: vacuum, channel: one,
     modbus: {address: 8, register_type: coil, command_on: [1, 0], command_off: [0, 1], pulse_s: 0.3}}
  b:
    {kind: vacuum, channel: two,
     modbus: {address: 5, bitmask: 0x0004, command_on: [1], command_off: [0], use_mask_write: true}}
supply: {channel: none}
"""
A, B = "modbus:1/0x0008", "modbus:1/0x0005.2"
PAIR = TOOL.replace("command_on: [1, 0], command_off: [0, 1]", "command_on: [1], command_off: [0], SECOND")


@pytest.mark.parametrize("pulse", ["", ", pulse_s: 0.3"])
def test_two_coils_far_apart_are_never_both_active(tmp_path: Path, pulse: str) -> None:
    second = f"opposite: {{address: 1}}{pulse}"
    with Station("socket", 1) as station:
        text = PAIR.replace("PORT", str(station.port)).replace("SECOND, pulse_s: 0.3", second)
        tool = examine_text(text, "tool.yaml").description
        assert tool is not None
        codec = cast(BusCodec, codec_of(tool))
        link = BusLink(tool.links[""].port, codec, *line_of(tool.links[""], codec))
        lines = BusLines(link, tool.register_outputs, tmp_path / "relay")
        with closing(ModbusTcpClient("127.0.0.1", port=station.port)) as seen, closing(lines):
            seen.write_coil(1, True, device_id=1)
            lines.request([A, B])
            found = set[tuple[bool, bool]]()

            def coils() -> tuple[bool, bool]:
                bits = seen.read_coils(0, count=10, device_id=1).bits
                found.add((bits[8], bits[1]))
                return bits[8], bits[1]

            for level, active in ((True, (True, False)), (False, (False, True)), (True, (True, False))):
                lines.set({A: level})
                wait_until(f"{active}", lambda active=active: coils() == active)
                wait_until("its end", lambda: not pulse or coils() == (False, False))
                wait_until("its acknowledgement", lambda level=level: lines.levels().get(A) is level)
            assert (True, True) not in found
            assert not lines.troubles()


def test_each_coil_is_active_for_its_pulse_and_bits_keep_their_neighbours(tmp_path: Path) -> None:
    with Station("socket", 1) as station:
        tool = examine_text(TOOL.replace("PORT", str(station.port)), "tool.yaml").description
        assert tool is not None
        codec = cast(BusCodec, codec_of(tool))
        link = BusLink(tool.links[""].port, codec, *line_of(tool.links[""], codec))
        lines = BusLines(link, tool.register_outputs, tmp_path / "relay")
        with closing(ModbusTcpClient("127.0.0.1", port=station.port)) as seen, closing(lines):
            seen.write_register(5, 0xF0F1, device_id=1)
            lines.request([A, B])

            def coils() -> list[bool]:
                return list(seen.read_coils(8, count=2, device_id=1).bits[:2])

            for level, pulse in ((True, [True, False]), (False, [False, True])):
                lines.set({A: level, B: level})
                wait_until(f"a pulse of {pulse}", lambda pulse=pulse: coils() == pulse)
                wait_until("its end", lambda: coils() == [False, False])
                wait_until("both", lambda level=level: lines.levels() == {A: level, B: level})
                assert seen.read_holding_registers(5, device_id=1).registers == [0xF0F5 if level else 0xF0F1]
            assert not lines.troubles()
