"""Text at an address in a network: as it comes, and from a serial port that pyserial's own server sets (RFC 2217)."""

from __future__ import annotations

import select
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from functools import partial

import pytest
from serial.rfc2217 import PortManager

from end_effector_hal.cli.doctor._check_result import Level
from end_effector_hal.cli.doctor._link import look_at_link
from end_effector_hal.codecs import codec_of
from end_effector_hal.description import Description, examine_text
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.link._reader import LinkReader
from tests.support.patience import wait_until
from tests.unit.wires.link.test_telnet import RemoteLine

pytestmark = [pytest.mark.wall, pytest.mark.timeout(60)]
TOOL = """
name: tool
link: {{port: "{port}", frame: {{text: {{start: "$"}}}}{more}}}
channels: {{cup: {{text: {{field: 1}}, unit: kPa}}}}
sequence: [a]
actuators: {{a: {{kind: vacuum, line: A, channel: cup}}}}
supply: {{channel: none}}
"""


def described(port: str, more: str = "") -> Description:
    found = examine_text(TOOL.format(port=port, more=more), "tool.yaml")
    assert found.description is not None, found.lines()
    return found.description


class Device:
    """Sends a line every 10 ms to the one that is connected; ``manages``: as a server of RFC 2217."""

    def __init__(self, *, manages: bool) -> None:
        self.line = RemoteLine()
        self._manages = manages
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._server.getsockname()[1]
        self._ended, self._cut = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def cut(self) -> None:
        self._cut.set()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._server.close()

    def _serve(self) -> None:
        while not self._ended.is_set():
            if select.select([self._server], [], [], 0.05)[0]:
                with (
                    self._server.accept()[0] as client,
                    suppress(ConnectionError),
                ):  # it is closed with a reset
                    self._talk(client)

    def _talk(self, client: socket.socket) -> None:
        manager = PortManager(self.line, self.line) if self._manages else None
        self._cut.clear()
        while not (self._ended.is_set() or self._cut.is_set()):
            if select.select([client], [], [], 0.01)[0]:
                data = client.recv(4096)
                if not data:
                    return
                if manager:
                    list(manager.filter(data))
            sent, self.line.sent = self.line.sent, b""
            client.sendall(sent + b"$-60.5\n")


@contextmanager
def device(*, manages: bool) -> Iterator[Device]:
    with closing(Device(manages=manages)) as found:
        yield found


@contextmanager
def reading(tool: Description) -> Iterator[Callable[[], LinkHealth]]:
    link, codec = tool.links[""], codec_of(tool)
    reader = LinkReader(link.port, codec, link.baudrate, parity=link.parity, stopbits=link.stopbits or 1)
    with reader:
        yield lambda: reader.health


def up(health: Callable[[], LinkHealth], opened: int) -> bool:
    now = health()
    return now.state is LinkState.UP and now.opened >= opened


@pytest.mark.parametrize("manages", [False, True], ids=["socket", "rfc2217"])
def test_frames_come_and_a_lost_connection_is_made_again(*, manages: bool) -> None:
    scheme = "rfc2217" if manages else "socket"
    with device(manages=manages) as far:
        more = ", baudrate: 9600, parity: E, stopbits: 2" if manages else ""
        with reading(described(f"{scheme}://127.0.0.1:{far.port}", more)) as health:
            wait_until("frames", partial(up, health, 1))
            far.cut()
            wait_until("frames again", partial(up, health, 2))
            assert not health().errors.get("noise")
        if manages:
            assert (far.line.baudrate, far.line.parity, far.line.stopbits) == (9600, "E", 2)


def test_the_doctor_says_what_to_look_at() -> None:
    with device(manages=False) as far:
        tool = described(f"socket://127.0.0.1:{far.port}")
        (said,) = look_at_link(tool)
        assert said.level is Level.OK, said
        assert "baud" not in said.what
    (said,) = look_at_link(tool)
    assert "the connection is refused" in said.what
    assert "port number" in said.todo
    (said,) = look_at_link(described("socket://no-such-device.invalid:1"))
    assert "the name no-such-device.invalid cannot be resolved" in said.what
