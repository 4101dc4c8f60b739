"""A serial port that is set over the network, as RFC 2217 describes it: options of Telnet; sans-IO."""

from __future__ import annotations

from typing import NamedTuple

IAC, DO_NOT, DO, WILL_NOT, WILL, SB, SE = 255, 254, 253, 252, 251, 250, 240
BINARY, SUPPRESS_GO_AHEAD, COM_PORT = 0, 3, 44
SET_BAUDRATE, SET_DATASIZE, SET_PARITY, SET_STOPSIZE = 1, 2, 3, 4
PARITIES = {"N": 1, "O": 2, "E": 3}
LONGEST_OPTION = 512


class SerialSettings(NamedTuple):
    """Settings of a serial line with 8 data bits."""

    baudrate: int
    parity: str = "N"
    stopbits: int = 1


class TelnetFrames:
    """Data between the commands of Telnet.

    Args:
        settings: of the line at the far end.
    """

    def __init__(self, settings: SerialSettings) -> None:
        self._settings = settings
        self._rest, self._replies = b"", b""

    @property
    def greeting(self) -> bytes:
        """The bytes to send first: the options and the settings of the line."""
        rate, parity, stopbits = self._settings
        options = [(WILL, BINARY), (DO, BINARY), (DO, SUPPRESS_GO_AHEAD), (WILL, COM_PORT)]
        said = b"".join(bytes([IAC, *option]) for option in options)
        for key, value in (
            (SET_BAUDRATE, rate.to_bytes(4, "big")),
            (SET_DATASIZE, bytes([8])),
            (SET_PARITY, bytes([PARITIES[parity]])),
            (SET_STOPSIZE, bytes([stopbits])),
        ):
            said += bytes([IAC, SB, COM_PORT, key]) + self.request(value) + bytes([IAC, SE])
        return said

    def request(self, frame: bytes) -> bytes:
        """Return data as they are sent: IAC is doubled."""
        return frame.replace(bytes([IAC]), bytes([IAC, IAC]))

    def feed(self, data: bytes) -> bytes:
        """Return the data between the commands.

        Raises:
            ValueError: the far end does not set serial lines, or sends an endless option.
        """
        rest, found, at = self._rest + data, bytearray(), 0
        while at < len(rest):
            if rest[at] != IAC:
                found.append(rest[at])
                at += 1
                continue
            size = _size(rest[at : at + LONGEST_OPTION])
            if not size:
                if len(rest) - at >= LONGEST_OPTION:
                    raise ValueError("the far end does not speak RFC 2217")
                break
            self._obey(rest[at : at + size], found)
            at += size
        self._rest = rest[at:]
        return bytes(found)

    def reply(self) -> bytes:
        """Return, once, what is to be replied to commands."""
        replies, self._replies = self._replies, b""
        return replies

    def _obey(self, command: bytes, found: bytearray) -> None:
        verb, option = command[1], command[2] if len(command) > 2 else 0
        if verb == IAC:
            found.append(IAC)
        elif verb == DO_NOT and option == COM_PORT:
            raise ValueError(
                "the far end does not set serial lines (RFC 2217): give socket:// and set it there"
            )
        elif verb == DO and option not in (BINARY, SUPPRESS_GO_AHEAD, COM_PORT):
            self._replies += bytes([IAC, WILL_NOT, option])
        elif verb == WILL and option not in (BINARY, SUPPRESS_GO_AHEAD, COM_PORT):
            self._replies += bytes([IAC, DO_NOT, option])


def _size(rest: bytes) -> int:
    """Return the number of bytes of the command that begins here; 0: it is not complete."""
    if len(rest) < 2:
        return 0
    if rest[1] == SB:
        end = rest.find(bytes([IAC, SE]), 2)
        return end + 2 if end >= 0 else 0
    size = 3 if rest[1] in (DO, DO_NOT, WILL, WILL_NOT) else 2
    return size if len(rest) >= size else 0
