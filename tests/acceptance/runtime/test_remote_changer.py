"""A tool whose only outputs are coils over TCP, its changer too; a station of pymodbus is the far end."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from pymodbus.client import ModbusTcpClient

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import examine_text
from end_effector_hal.runtime import EndEffector
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import wait_until
from tests.support.places import ROOT
from tests.support.tcp_wire import Station, TcpWire

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
TOOL = ROOT / "examples" / "tools" / "remote_changer" / "end_effector.yaml"
READY_S = 30.0
UNLOCK = 0
"""Its coil; 1 is the cup, 2 the blow-off, 3 the lamp."""


@contextmanager
def world(folder: Path, port: int, **changes: str) -> Iterator[World]:
    text = TOOL.read_text().replace("tcp://192.168.1.20 ", f"tcp://127.0.0.1:{port} ")
    text = text.replace("backend: gpiod", f"backend: virtual, path: {folder / 'chip'}")
    for old, new in changes.items():
        text = text.replace(f"{old}:", new, 1)
    tool = examine_text(text, "tool.yaml").description
    assert tool is not None
    with World(tool, "nominal", folder, own_wires=True) as found:
        yield found


@contextmanager
def station() -> Iterator[tuple[Station, ModbusTcpClient]]:
    with Station("socket", 1) as found:
        client = ModbusTcpClient("127.0.0.1", port=found.port)
        try:
            yield found, client
        finally:
            client.close()


def coils(client: ModbusTcpClient) -> list[bool]:
    return list(client.read_coils(0, count=4, device_id=1).bits[:4])


def test_it_grips_blows_off_and_changes_the_tool(tmp_path: Path) -> None:
    with (
        station() as (far, seen),
        world(tmp_path, far.port) as tool,
        EndEffector.open(tool.description) as hal,
    ):
        hal.wait_ready(READY_S)
        assert hal.set_output("lamp", True).accepted
        wait_until("the lamp", lambda: hal.outputs == {"lamp": True})
        assert hal.grip().succeeded
        assert coils(seen) == [False, True, False, True]
        assert not hal.unlock().succeeded, "IL-01"
        assert hal.drop().succeeded
        assert coils(seen) == [False, False, False, True]
        assert hal.unlock().succeeded
        assert coils(seen)[UNLOCK]
        assert not hal.grip().succeeded, "IL-05"
        assert hal.lock().succeeded
        assert not coils(seen)[UNLOCK]


def test_the_arbiter_ends_an_unlock_by_itself_when_the_network_is_back(tmp_path: Path) -> None:
    """The program is killed and leaves the output as it is, and the network is away when IL-03 ends it."""
    holds = {"tool_changer": "tool_changer:\n  endings: {process_death: hold}"}
    with (
        station() as (far, seen),
        TcpWire(far.port) as wire,
        world(tmp_path, wire.port, **holds) as tool,
        ArbiterClient(tool.socket, "test") as observer,
    ):
        words = [*EEHAL, "run", str(tool.description_path), "--script", "unlock; wait 600"]
        program = tool.children.start("program", words, log=tool.folder / "program.log")
        wait_until("it unlocks", lambda: coils(seen)[UNLOCK], READY_S)
        os.kill(program.pid, signal.SIGKILL)
        wire.deaf = True
        told = "until its device acknowledges it"
        wait_until("IL-03", lambda: any(told in why for why in observer.status()["faults"].values()))
        assert coils(seen)[UNLOCK], "nothing reaches the station"
        wire.deaf = False
        wait_until("it locks", lambda: not coils(seen)[UNLOCK])
