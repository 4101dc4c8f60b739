"""A tool whose only outputs are coils over TCP, with all its processes; a station of pymodbus is the far end."""

from __future__ import annotations

from pathlib import Path

import pytest
from pymodbus.client import ModbusTcpClient

from end_effector_hal.description import examine_text
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._world import World
from tests.support.patience import wait_until
from tests.support.places import ROOT
from tests.support.tcp_wire import Station, TcpWire

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
TOOL = ROOT / "examples" / "tools" / "remote_io" / "end_effector.yaml"
READY_S = 30.0


def test_a_held_part_stays_held_while_the_network_is_away_and_is_dropped_when_it_is_back(
    tmp_path: Path,
) -> None:
    with Station("socket", 1) as station, TcpWire(station.port) as wire:
        text = TOOL.read_text().replace("tcp://192.168.1.20 ", f"tcp://127.0.0.1:{wire.port} ")
        text = text.replace("backend: gpiod", f"backend: virtual, path: {tmp_path / 'chip'}")
        tool = examine_text(text, "tool.yaml").description
        assert tool is not None
        seen = ModbusTcpClient("127.0.0.1", port=station.port)
        with (
            World(tool, "nominal", tmp_path, own_wires=True) as world,
            EndEffector.open(world.description) as hal,
        ):
            hal.wait_ready(READY_S)
            assert hal.grip().succeeded
            assert seen.read_coils(0, count=2, device_id=1).bits[:2] == [True, True]
            wire.deaf = True
            wait_until("the alarm", lambda: any("is down" in alarm for alarm in hal.status.alarm_texts))
            assert hal.status.ee == EndEffectorState.GRIPPED
            assert seen.read_coils(0, count=2, device_id=1).bits[:2] == [True, True]
            assert not hal.drop().succeeded  # nothing proves it
            assert seen.read_coils(0, count=2, device_id=1).bits[:2] == [True, True]
            wire.deaf = False
            wait_until("it is let go", lambda: not any(seen.read_coils(0, count=2, device_id=1).bits[:2]))
            wait_until(
                "it is proven", lambda: hal.drop().succeeded or hal.status.ee == EndEffectorState.STAND_BY
            )
        seen.close()
