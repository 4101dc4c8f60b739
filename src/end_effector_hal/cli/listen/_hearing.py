"""Reads a sensor link of a tool without an arbiter and without moving a line."""

from __future__ import annotations

import select
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass

from end_effector_hal.codecs import Codec, codec_names, codec_of, get_codec, line_of
from end_effector_hal.description import Description, has_line
from end_effector_hal.errors import ReportedError
from end_effector_hal.signals import Frame
from end_effector_hal.wires.link import CodecCalls, GuardedDecoder, WirePort, open_wire


@dataclass(frozen=True)
class OpenLink:
    """The open port of a link with the decoder of its data.

    Attributes:
        name: port, codec and baud rate for a sentence.
        codec: codec of the link.
        decoder: a new decoder for the link.
        port: the open port.
    """

    name: str
    codec: Codec
    decoder: GuardedDecoder
    port: WirePort

    def hear(self, longest_s: float) -> tuple[bytes, list[Frame]]:
        """Return the bytes that arrive within a time, and the frames that end in them; a polling codec sends its
        requests.

        Raises:
            OSError: the port is gone.
            CodecFailure: the codec failed.
        """
        frames: list[Frame] = []
        if self.decoder.asks:
            polled = self.decoder.poll()
            if polled.data:
                self.port.write(polled.data)
            frames += polled.frames
            longest_s = min(longest_s, self.decoder.wait_s() or 0)
        if not select.select([self.port.fileno()], [], [], longest_s)[0]:
            return b"", frames
        data = self.port.read()
        return data, [*frames, *self.decoder.feed(data)]


def link_title(description: Description, name: str) -> str:
    """Return port, codec and baud rate of a link for a sentence; raises UsageError like `codec_of`."""
    codec, link = codec_of(description, name), description.links[name]
    rate = f", {line_of(link, codec)[0]} baud" if has_line(link.port) else ""
    return f"{link.port}, {codec.name}{rate}"


@contextmanager
def open_link(description: Description, name: str) -> Iterator[OpenLink]:
    """Open a link of a tool for the duration of the context.

    Args:
        name: name of the link.

    Raises:
        LinkError: the port cannot be opened; LinkBusyError: another process reads it.
        UsageError: the codec cannot be loaded.
    """
    codec, link = codec_of(description, name), description.links[name]
    baudrate, parity, stopbits = line_of(link, codec)
    with closing(open_wire(link.port, baudrate, parity=parity, stopbits=stopbits)) as port:
        if port.connecting:
            select.select([port.fileno()], [], [])
            port.establish()
        decoder = GuardedDecoder(codec, CodecCalls(link.port))
        yield OpenLink(link_title(description, name), codec, decoder, port)


def fitting(data: bytes, but: str) -> Iterator[str]:
    """Yield the codecs other than ``but`` that find more frames than errors in the data."""
    for name in codec_names():
        if name == but:
            continue
        try:
            decoder = GuardedDecoder(get_codec(name), CodecCalls(name))
            frames, counters = decoder.feed(data), decoder.counters
        except ReportedError:  # somebody else's, and broken
            continue
        if frames and counters.frames > sum(
            count for kind, count in counters.errors.items() if kind != "noise"
        ):
            yield name


def why_no_frame(data: bytes, codec: str, *, network: bool = False) -> tuple[str, str]:
    """Return the problem and its remedy if no frame arrived.

    Args:
        data: all that arrived.
        codec: its name; "" if the frame is declared in the description.
        network: whether the port is an address in a network.
    """
    if not data:
        powered = "Is the device powered, RX and TX not exchanged, the ground connected?"
        asked = (
            "Is this the right port number? Does the device send, or serve, what the description declares?"
        )
        return "silent", asked if network else powered
    others = ", ".join(fitting(data, but=codec))
    json = not others and any(
        line.startswith(b"{") and line.rstrip().endswith(b"}") for line in data.split(b"\n")
    )
    looks = "lines of JSON" if json else others
    what = f"{len(data)} bytes and no frame" + (f"; they look like {looks}" if looks else "")
    if json:
        return what, "Write frame: {json: {}} for the link, and json: {key: …} with the path of each channel."
    if others:
        return what, f"Set link.codec: {others}."
    frame = "codec" if codec else "link.frame"
    wire = "at the far end" if network else "and voltage levels"
    return what, f"Baud rate, parity, {frame} {wire}: do they fit?"
