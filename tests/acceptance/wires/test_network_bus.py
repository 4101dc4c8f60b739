"""A bus at an address in a network: the line arbiter's part of it, a server of pymodbus as the far end, and what a
network does between them.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import cast

import pytest
from pymodbus.client import ModbusTcpClient

from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.codecs.modbus import BusCodec
from end_effector_hal.description import Description, examine_text
from end_effector_hal.errors import LinkBusyError
from end_effector_hal.wires.bus import BusLink
from end_effector_hal.wires.bus._lines import BusLines
from end_effector_hal.wires.link import open_wire, users_of
from tests.support.patience import wait_until
from tests.support.places import ROOT
from tests.support.tcp_wire import Station, TcpWire

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
TOOL = ROOT / "examples" / "tools" / "remote_io" / "end_effector.yaml"
LIFT, CUP = "modbus:1/0x0000", "modbus:1/0x0001"
AT_ONCE_S = 2.0
"""Longest time in which a command is handed over, on a busy machine; a connection takes longer to fail."""


def remote_io(port: str) -> Description:
    found = examine_text(TOOL.read_text().replace("tcp://192.168.1.20 ", f"{port} "), "tool.yaml")
    assert found.description is not None, found.lines()
    return found.description


@contextmanager
def bus(port: str, folder: Path) -> Iterator[BusLines]:
    tool = remote_io(port)
    link, codec = tool.links[""], codec_of(tool)
    lines = BusLines(
        BusLink(port, cast(BusCodec, codec), *line_of(link, codec)), tool.register_outputs, folder / "relay"
    )
    lines.request([LIFT, CUP])
    try:
        yield lines
    finally:
        lines.close()


def command(lines: BusLines, levels: Mapping[str, bool]) -> None:
    before = time.monotonic()
    lines.set(levels)
    lines.troubles()
    assert time.monotonic() - before < AT_ONCE_S


def known(lines: BusLines, levels: Mapping[str, bool]) -> None:
    wait_until(f"{levels}", lambda: lines.levels() == levels)


@pytest.mark.parametrize("scheme", ["tcp", "rtu+tcp"])
def test_coils_are_read_and_written(scheme: str, tmp_path: Path) -> None:
    with (
        Station("socket" if scheme == "tcp" else "rtu", 1) as station,
        bus(f"{scheme}://127.0.0.1:{station.port}", tmp_path) as lines,
    ):
        known(lines, {LIFT: False, CUP: False})
        command(lines, {LIFT: True})
        known(lines, {LIFT: True, CUP: False})
        command(lines, {LIFT: False, CUP: True})
        known(lines, {LIFT: False, CUP: True})
        assert not lines.troubles()


def another_transaction(answer: bytes) -> bytes:
    return bytes([answer[0] ^ 0x80]) + answer[1:]


FAULTS: dict[str, Callable[[TcpWire], None]] = {
    "deaf": lambda wire: setattr(wire, "deaf", True),
    "slow": lambda wire: setattr(wire, "delay_s", 0.3),
    "another transaction": lambda wire: setattr(wire, "change", another_transaction),
    "a huge length": lambda wire: setattr(
        wire, "change", lambda answer: answer[:4] + b"\xff\xff" + answer[6:]
    ),
    "cut in the middle of an answer": lambda wire: setattr(
        wire, "change", lambda answer: _half(wire, answer)
    ),
}


def _half(wire: TcpWire, answer: bytes) -> bytes:
    wire.reset()
    return answer[:5]


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_not_acknowledged_is_unknown_and_a_release_is_done_when_the_network_is_back(
    fault: str, tmp_path: Path
) -> None:
    with Station("socket", 1) as station, TcpWire(station.port) as wire:
        port = f"tcp://127.0.0.1:{wire.port}"
        with bus(port, tmp_path) as lines:
            command(lines, {LIFT: True, CUP: True})
            known(lines, {LIFT: True, CUP: True})
            FAULTS[fault](wire)
            command(lines, {CUP: False})
            wait_until("it is a trouble", lambda: "is to be deactivated" in lines.troubles().get(CUP, ""))
            assert CUP in lines.owed()
            assert CUP in lines.unsure()
            if fault != "slow" and fault != "another transaction":
                before = wire.connections
                wait_until("it connects again", lambda: wire.connections > before)
            wire.deaf, wire.delay_s, wire.change = False, 0.0, lambda answer: answer
            known(lines, {LIFT: True, CUP: False})
            assert not lines.owed()


def test_a_second_client_that_writes_the_same_coils_is_a_trouble_where_they_are_read_back(
    tmp_path: Path,
) -> None:
    with (
        Station("socket", 1) as station,
        bus(f"tcp://127.0.0.1:{station.port}", tmp_path) as lines,
        ModbusTcpClient("127.0.0.1", port=station.port) as other,
    ):
        command(lines, {CUP: True})
        known(lines, {LIFT: False, CUP: True})
        assert not other.write_coil(1, value=False, device_id=1).isError()
        wait_until("it is a trouble", lambda: "another program writes to it" in lines.troubles().get(CUP, ""))
        assert CUP in lines.unsure()
        command(lines, {CUP: True})
        known(lines, {LIFT: False, CUP: True})
        assert not lines.troubles()


def test_a_device_that_is_off_at_the_start_delays_nothing_and_is_found_later(tmp_path: Path) -> None:
    with Station("socket", 1) as station:
        wire = TcpWire(station.port)
        port = wire.port
        wire.close()
        with bus(f"tcp://127.0.0.1:{port}", tmp_path) as lines:
            command(lines, {CUP: False})
            wait_until(
                "it is a trouble", lambda: "the connection is refused" in lines.troubles().get(CUP, "")
            )
            command(lines, {LIFT: True})
            wait_until("it is given up", lambda: "was not activated" in lines.troubles().get(LIFT, ""))
            again = TcpWire(station.port, port)
            known(lines, {CUP: False})
            assert "was not activated" in lines.troubles()[LIFT]
            again.close()


def test_a_device_that_does_not_even_refuse_delays_nothing(tmp_path: Path) -> None:
    """Its queue of connections is full, so that the kernel answers no more of them: as if it were off."""
    with socket.create_server(("127.0.0.1", 0), backlog=0) as far, ExitStack() as waiting:
        for each in [waiting.enter_context(socket.socket()) for _ in range(4)]:
            each.setblocking(False)
            each.connect_ex(far.getsockname())
        with bus(f"tcp://127.0.0.1:{far.getsockname()[1]}", tmp_path) as lines:
            command(lines, {CUP: False})
            command(lines, {LIFT: True})
            wait_until("it is given up", lambda: "was not activated" in lines.troubles().get(LIFT, ""))
            wait_until(
                "it is a trouble", lambda: "the device does not answer" in lines.troubles().get(CUP, "")
            )
            assert lines.owed() == {CUP}


SECOND = """
import sys
from end_effector_hal.wires.link import open_wire
port = open_wire(sys.argv[1], 0)
sys.stdout.write("open\\n")
sys.stdout.flush()
sys.stdin.read()
"""


@contextmanager
def second_program(port: str) -> Iterator[int]:
    """Another program with this port; its pid."""
    words = [sys.executable, "-c", SECOND, port]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == b"open\n"
        yield program.pid
        program.kill()


@pytest.mark.parametrize("scheme", ["tcp", "rtu+tcp"])
def test_an_address_has_one_master_on_a_machine(scheme: str, tmp_path: Path) -> None:
    """A second link, in this process or in another one, is refused with the name of the first."""
    port = "127.0.0.1:15020"  # nothing listens there
    with closing(open_wire(f"tcp://{port}", 0)), pytest.raises(LinkBusyError) as refused:
        open_wire(f"{scheme}://{port}", 0)
    assert f"the address is used by pid {os.getpid()} (" in refused.value.what
    with second_program(f"{scheme}://{port}") as pid:
        with pytest.raises(LinkBusyError) as refused, bus(f"tcp://{port}", tmp_path):
            pass
        assert f"the address is used by pid {pid} (" in refused.value.what
        assert [each.pid for each in users_of(f"tcp://{port}")] == [pid]
    assert users_of(f"tcp://{port}") == []
    open_wire(f"tcp://{port}", 0).close()
