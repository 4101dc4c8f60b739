"""A testbench that serves its device at an address of this machine: pymodbus's client commands and reads it."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from pymodbus import FramerType
from pymodbus.client import ModbusTcpClient

from end_effector_hal.description import examine_text, network_address
from end_effector_hal.errors import LinkError
from end_effector_lab.testbench import Testbench, open_inputs, open_ports
from tests.support.patience import wait_until
from tests.support.places import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(60)]
TOOL = ROOT / "examples" / "tools" / "remote_io" / "end_effector.yaml"
FRAMES = {"tcp://": FramerType.SOCKET, "rtu+tcp://": FramerType.RTU}


@pytest.mark.parametrize("scheme", FRAMES)
def test_a_client_of_another_maker_moves_the_device(scheme: str, tmp_path: Path) -> None:
    text = TOOL.read_text().replace("tcp://192.168.1.20 ", f"{scheme}192.168.1.20:502 ")
    described = examine_text(text, "tool.yaml").description
    assert described is not None
    tool = described.with_virtual(tmp_path / "chip", str(tmp_path / "uart"))
    address = network_address(tool.links[""].port)
    assert address is not None
    with (
        Testbench(tool, open_inputs(None, tool), open_ports(None, tool, None)),
        ModbusTcpClient(address.host, port=address.port, framer=FRAMES[scheme]) as client,
        ModbusTcpClient(address.host, port=address.port, framer=FRAMES[scheme]) as other,
    ):

        def ends() -> list[bool]:
            return list(client.read_discrete_inputs(0, count=2).bits[:2])

        wait_until("it is up", lambda: ends() == [False, True])
        assert not client.write_coil(0, value=True).isError()
        assert other.read_coils(0, count=2).bits[:2] == [True, False]
        wait_until("it is down", lambda: ends() == [True, False])
        assert not other.write_coil(0, value=False).isError()
        wait_until("it is up again", lambda: ends() == [False, True])


def test_an_address_of_another_machine_is_refused_in_a_sentence(tmp_path: Path) -> None:
    described = examine_text(TOOL.read_text().replace("gpiod", f"virtual, path: {tmp_path}/chip"), "t.yaml")
    assert described.description is not None
    (port,) = open_ports("tcp://192.0.2.1:502", described.description, None).values()
    with pytest.raises(LinkError) as refused:
        port.open()
    assert "the simulated device cannot be served here" in refused.value.what
    assert "--prepare" in refused.value.todo


def test_a_port_that_is_closed_refuses_and_an_answer_may_end_in_the_middle(tmp_path: Path) -> None:
    described = examine_text(TOOL.read_text(), "tool.yaml").description
    assert described is not None
    tool = described.with_virtual(tmp_path / "chip", str(tmp_path / "uart"))
    address = network_address(tool.links[""].port)
    assert address is not None
    request = bytes.fromhex("0007 0000 0006 01 02 0000 0002")

    def asked() -> bytes:
        """Return what comes for a read before the connection ends, or a whole answer."""
        with socket.create_connection((address.host, address.port), timeout=5) as near:
            near.sendall(request)
            data = b""
            while len(data) < 10:
                data += (part := near.recv(100))
                if not part:
                    break
            return data

    with Testbench(tool, open_inputs(None, tool), open_ports(None, tool, None)) as bench:
        wait_until("it answers", lambda: asked()[:6] == bytes.fromhex("0007 0000 0004"))
        bench.choose("closed-after:0")
        wait_until("it refuses", lambda: _raises(ConnectionRefusedError, asked))
        bench.choose("cut-answers:1")
        wait_until("it resets", lambda: _raises(ConnectionResetError, asked))
        bench.choose("nominal")
        wait_until("it answers again", lambda: len(asked()) == 10)


def _raises(kind: type[OSError], asked: Callable[[], bytes]) -> bool:
    try:
        asked()
    except OSError as error:
        return isinstance(error, kind)
    return False
