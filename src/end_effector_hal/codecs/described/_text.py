"""Lines of text: separated fields or ``key=value``, with a start and a checksum if these are declared."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.codecs.described._codec import DescribedCodec, DescribedDecoder, SerialLine, by_place
from end_effector_hal.codecs.described._field import CHECKSUMS, Field
from end_effector_hal.description import Channel, TextFrame, TextValue
from end_effector_hal.signals import Frame

LONGEST, OF_A_VALUE = 1024, 16
"""Longest line, bytes: the larger of the first number and of the second one times the number of values."""
_NUMBER = re.compile(rb"[+-]?([0-9]{1,15}(\.[0-9]{0,15})?|\.[0-9]{1,15})([eE][+-]?[0-9]{1,2})?")
NO_VALUE = b"-"
"""Text for an empty field where blanks separate the fields."""


@dataclass(frozen=True)
class Layout:
    """The layout of a line, in bytes."""

    start: bytes
    separator: bytes
    equals: bytes
    checksum: str
    mark: bytes
    places: tuple[TextValue, ...]
    fields: tuple[Field, ...]

    @property
    def marked(self) -> bool:
        """Whether a whole line can be distinguished from the end of one."""
        return bool(self.start) or self.checksum != "none"

    @property
    def longest(self) -> int:
        """Longest line, bytes."""
        values = max([len(self.places), *(each.field or 0 for each in self.places)])
        return max(LONGEST, OF_A_VALUE * values)

    @property
    def blanks(self) -> bool:
        """Whether any number of blanks separates the fields."""
        return self.separator == b" "


class DescribedText(DescribedCodec):
    """The codec of declared lines of text.

    Args:
        frame: the format of the lines.
        channels: the channels in them.
        line: settings of the link.
    """

    def __init__(self, frame: TextFrame, channels: Mapping[str, Channel], line: SerialLine) -> None:
        places: dict[TextValue, dict[str, Channel]] = by_place(channels, "text")
        # how long a line is, is the device's: a digit and what separates it for each value
        super().__init__(channels, line, len(places) * 2 * line.byte_bits * 1_000_000 // line.baudrate)
        self._layout = Layout(
            frame.start.encode(),
            frame.separator.encode(),
            frame.equals.encode(),
            frame.checksum,
            frame.checksum_mark.encode(),
            tuple(places),
            tuple(map(Field, places.values())),
        )

    def decoder(self) -> Decoder:
        """Return a new decoder."""
        return TextDecoder(self._layout, self.period_us)

    def encode(self, frame: Frame) -> bytes:
        """Return one line, without channels that have no value; no bytes if no channel has a value."""
        layout = self._layout
        fields: dict[int, bytes] = {}
        keyed: list[bytes] = []
        told = False
        for place, field in zip(layout.places, layout.fields, strict=True):
            raw = field.raw(frame.values)
            text = b"" if raw is None else _written(raw, place)
            told = told or bool(text)
            if place.field is not None:
                fields[place.field] = text
            elif text and place.key is not None:
                keyed.append(place.key.encode() + layout.equals + text)
        if not told:
            return b""
        tokens = []
        for number in range(1, max(fields, default=0) + 1):
            filled = keyed.pop(0) if number not in fields and keyed else b"0"
            tokens.append(fields.get(number, filled) or (NO_VALUE if layout.blanks else b""))
        body = layout.separator.join([*tokens, *keyed])
        size, of = CHECKSUMS[layout.checksum]
        checksum = layout.mark + b"%0*X" % (2 * size, of(body)) if size else b""
        return layout.start + body + checksum + b"\r\n"


class TextDecoder(DescribedDecoder):
    """Keeps at most one unfinished line; if lines have a start, every start begins a new line.

    Without start and checksum, the first line (and the first one after a gap or an error) may be the end of a line: it
    is discarded.
    """

    def __init__(self, layout: Layout, period_us: int) -> None:
        super().__init__(period_us)
        self._layout, self._in_step = layout, layout.marked

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        if not self._layout.marked and self._interrupted(at, data.count(b"\n")):
            self._in_step = False
        *lines, rest = (self._rest + data).split(b"\n")
        frames = [frame for line in lines if (frame := self._line(line, at))]
        self._rest = self._kept(rest)
        return frames

    def _kept(self, rest: bytes) -> bytes:
        """Return the bytes that can still become a line.

        One byte too many is kept, so that a line that is too long is detected however the data is split.
        """
        start, longest = self._layout.start, self._layout.longest
        if not start:
            self.errors["noise"] += max(0, len(rest) - longest - 1)
            return rest[: longest + 1]
        begins = rest.rfind(start)
        if begins < 0 or len(rest) - begins > longest:
            begins = max(0, len(rest) - len(start) + 1)  # a part of a start may stand at its end
        self.errors["noise"] += begins
        return rest[begins:]

    def _line(self, line: bytes, at: int) -> Frame | None:
        if not self._in_step:
            self._in_step = True
            self.errors["noise"] += len(line)
            return None
        frame = self._read(line, at)
        self._in_step = frame is not None or self._layout.marked
        return frame

    def _read(self, line: bytes, at: int) -> Frame | None:
        layout = self._layout
        begins = line.rfind(layout.start) if layout.start else 0
        if begins < 0:
            self.errors["noise"] += len(line)
            return None
        self.errors["noise"] += begins
        line = line[begins:]
        if len(line) > layout.longest:
            self.errors["format"] += 1
            return None
        body = line.removeprefix(layout.start).removesuffix(b"\r")
        size, of = CHECKSUMS[layout.checksum]
        if size:
            body, _, digits = body.rpartition(layout.mark)
            if not re.fullmatch(rb"[0-9A-Fa-f]{%d}" % (2 * size), digits):
                self.errors["format"] += 1
                return None
            if int(digits, 16) != of(body):
                self.errors["crc"] += 1
                return None
        return self._decoded(body, at)

    def _decoded(self, body: bytes, at: int) -> Frame | None:
        """Return the frame; None (a format error): the line is too short, repeats a key, or contains no number."""
        layout = self._layout
        tokens = [each.strip() for each in body.split(None if layout.blanks else layout.separator)]
        pairs = [
            (key.strip(), text.strip()) for key, _, text in (each.partition(layout.equals) for each in tokens)
        ]
        keyed = dict(pairs)
        texts: list[bytes] = []
        for place in layout.places:
            key = place.key.encode() if place.key is not None else b""
            if place.field is not None and place.field > len(tokens):
                break
            if place.field is None and sum(each == key for each, _ in pairs) > 1:
                break
            texts.append(tokens[place.field - 1] if place.field is not None else keyed.get(key, b""))
        raws = [float(text) if _NUMBER.fullmatch(text) else None for text in texts]
        if len(raws) < len(layout.places) or all(raw is None for raw in raws):
            self.errors["format"] += 1
            return None
        unread = any(
            raw is None and text not in (b"", NO_VALUE) for raw, text in zip(raws, texts, strict=True)
        )
        self.errors["value"] += unread
        return self._frame(at, layout.fields, raws)


def _written(raw: float, place: TextValue) -> bytes:
    if place.decimals is not None:
        return b"%.*f" % (place.decimals, raw)
    return b"%.10g" % raw
