"""A serial port that is set over the network: the bytes of RFC 2217, with pyserial's own server as the far end."""

from __future__ import annotations

import pytest
from serial.rfc2217 import PortManager

from end_effector_hal.wires.link._telnet import SerialSettings, TelnetFrames

IAC = b"\xff"


class RemoteLine:
    """The serial port of the server, which `PortManager` sets; and what the server sends."""

    def __init__(self) -> None:
        self.baudrate, self.bytesize, self.parity, self.stopbits = 1200, 7, "N", 1
        self.rts = self.dtr = True
        self.cts = self.dsr = self.ri = self.cd = False
        self.sent = b""

    def write(self, data: bytes) -> None:
        self.sent += data

    def get_settings(self) -> dict[str, object]:
        return dict(vars(self))


@pytest.mark.parametrize("settings", [SerialSettings(9600, "E", 2), SerialSettings(255, "O", 1)])
def test_the_far_end_gets_the_settings_of_the_line_and_data_pass_unchanged(settings: SerialSettings) -> None:
    line, frames = RemoteLine(), TelnetFrames(settings)
    server = PortManager(line, line)
    greeting = frames.greeting + frames.request(b"READ\xff\r")
    received = b"".join(server.filter(greeting))
    assert received == b"READ\xff\r"
    assert (line.baudrate, line.bytesize, line.parity, line.stopbits) == (
        settings.baudrate,
        8,
        settings.parity,
        settings.stopbits,
    )
    assert frames.feed(line.sent + b"".join(server.escape(b"12.5\xff kg\n"))) == b"12.5\xff kg\n"


def test_commands_are_removed_however_they_are_cut() -> None:
    data = b"a" + IAC + b"\xfd\x01" + b"b" + IAC + b"\xfa\x2c\x6a\x00" + IAC + b"\xf0" + b"c" + IAC + IAC
    for cut in range(len(data)):
        frames = TelnetFrames(SerialSettings(9600))
        assert frames.feed(data[:cut]) + frames.feed(data[cut:]) == b"abc\xff"
        assert frames.reply() == IAC + b"\xfc\x01"
        assert frames.reply() == b""


def test_a_far_end_without_the_option_or_without_an_end_is_refused() -> None:
    with pytest.raises(ValueError, match="does not set serial lines"):
        TelnetFrames(SerialSettings(9600)).feed(IAC + b"\xfe\x2c")
    with pytest.raises(ValueError, match="does not speak RFC 2217"):
        TelnetFrames(SerialSettings(9600)).feed(IAC + b"\xfa" + b"x" * 1000)
