"""Lines of text: separated fields or ``key=value``, with a start and a checksum if these are declared."""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from end_effector_hal.codecs.described._codec import DescribedCodec, DescribedDecoder, SerialLine, by_place
from end_effector_hal.codecs.described._field import CHECKSUMS, Field
from end_effector_hal.description import NUMBER, Channel, JsonValue, TextFrame, TextValue
from end_effector_hal.signals import Frame

LONGEST, OF_A_VALUE = 1024, 16
"""Longest line, bytes: the larger of the first number and of the second one times the number of values."""
NO_VALUE = b"-"
"""Text for an empty field where blanks separate the fields."""
TRUTH = {"true": 1.0, "false": 0.0}
"""The raw values of two words, for a bit that has no words of its own."""

Place = TextValue | JsonValue


class DescribedLines(DescribedCodec):
    """The base of codecs of lines, whose values are texts.

    Args:
        places: the channels by their places.
        line: settings of the link.
    """

    def __init__(
        self, places: Mapping[Place, Mapping[str, Channel]], line: SerialLine, of_a_value: int = 2
    ) -> None:
        channels = {name: each for group in places.values() for name, each in group.items()}
        # how long a line is, is the device's: a digit and what separates it for each value
        super().__init__(channels, line, line.wire_us(len(places) * of_a_value))
        self.places, self.fields = tuple(places), tuple(map(Field, places.values()))

    @abstractmethod
    def decoder(self) -> LineDecoder:
        """Return a new decoder for one stream."""

    @abstractmethod
    def line(self, texts: Sequence[bytes]) -> bytes:
        """Return the line with the text of each place; b"": it has no value."""

    def encode(self, frame: Frame) -> bytes:
        """Return one line, without channels that have no value; no bytes if no channel has a value."""
        raws = [field.sent(frame.values) for field in self.fields]
        texts = [
            b"" if raw is None else _written(raw, place) for raw, place in zip(raws, self.places, strict=True)
        ]
        return self.line(texts) if any(texts) else b""


@dataclass(frozen=True)
class Layout:
    """The layout of a line of fields, in bytes."""

    start: bytes
    separator: bytes
    equals: bytes
    checksum: str
    mark: bytes

    @property
    def blanks(self) -> bool:
        """Whether any number of blanks separates the fields."""
        return self.separator == b" "


class DescribedText(DescribedLines):
    """The codec of declared lines of text.

    Args:
        frame: the format of the lines.
        channels: the channels in them.
        line: settings of the link.
    """

    def __init__(self, frame: TextFrame, channels: Mapping[str, Channel], line: SerialLine) -> None:
        super().__init__(by_place(channels, "text"), line)
        self._layout = Layout(
            frame.start.encode(),
            frame.separator.encode(),
            frame.equals.encode(),
            frame.checksum,
            frame.checksum_mark.encode(),
        )

    def decoder(self) -> TextDecoder:
        """Return a new decoder."""
        return TextDecoder(self, self._layout)

    def line(self, texts: Sequence[bytes]) -> bytes:
        """Return the line with these texts."""
        layout = self._layout
        fields: dict[int, bytes] = {}
        keyed: list[bytes] = []
        for place, text in zip(self.places, texts, strict=True):
            assert isinstance(place, TextValue)
            if place.field is not None:
                fields[place.field] = text
            elif text and place.key is not None:
                keyed.append(place.key.encode() + layout.equals + text)
        tokens = []
        for number in range(1, max(fields, default=0) + 1):
            filled = keyed.pop(0) if number not in fields and keyed else b"0"
            tokens.append(fields.get(number, filled) or (NO_VALUE if layout.blanks else b""))
        body = layout.separator.join([*tokens, *keyed])
        size, of = CHECKSUMS[layout.checksum]
        checksum = layout.mark + b"%0*X" % (2 * size, of(body)) if size else b""
        return layout.start + body + checksum + b"\r\n"


class LineDecoder(DescribedDecoder):
    """Keeps at most one unfinished line; if lines have a start, every start begins a new line.

    If nothing distinguishes a whole line from the end of one (not ``marked``), the first line, and the first one after
    a gap or an error, is discarded.

    Args:
        codec: has the places and the fields of a line.
        start: first bytes of each line.
        marked: whether a whole line can be distinguished from the end of one.
        longest: longest line, bytes.
    """

    def __init__(self, codec: DescribedLines, *, start: bytes, marked: bool, longest: int) -> None:
        super().__init__(codec.period_us)
        self._places, self._fields = codec.places, codec.fields
        self._start, self._marked, self._longest = start, marked, longest
        self._in_step = marked

    def begin(self, *, in_step: bool) -> None:
        """Expect an answer next: a beginning of a line if ``in_step``; an unfinished line is discarded."""
        self.errors["noise"] += len(self._rest)
        self._rest, self._marked, self._in_step = b"", True, in_step

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        if not self._marked and self._interrupted(at, data.count(b"\n")):
            self._in_step = False
        *lines, rest = (self._rest + data).split(b"\n")
        frames = [frame for line in lines if (frame := self._line(line, at))]
        self._rest = self._kept(rest)
        return frames

    def _kept(self, rest: bytes) -> bytes:
        """Return the bytes that can still become a line.

        One byte too many is kept, so that a line that is too long is detected however the data is split.
        """
        start, longest = self._start, self._longest
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
        self._in_step = frame is not None or self._marked
        return frame

    def _read(self, line: bytes, at: int) -> Frame | None:
        begins = line.rfind(self._start) if self._start else 0
        if begins < 0:
            self.errors["noise"] += len(line)
            return None
        self.errors["noise"] += begins
        line = line[begins:]
        texts = self._texts(line.removeprefix(self._start)) if len(line) <= self._longest else "format"
        if isinstance(texts, str):
            self.errors[texts] += 1
            return None
        raws = [_raw(text, field) for text, field in zip(texts, self._fields, strict=True)]
        if all(raw is None for raw in raws):
            self.errors["format"] += 1
            return None
        unread = any(
            raw is None and text not in (b"", NO_VALUE) for raw, text in zip(raws, texts, strict=True)
        )
        self.errors["value"] += unread
        return self._frame(at, self._fields, raws)

    @abstractmethod
    def _texts(self, line: bytes) -> Sequence[bytes] | str:
        """Return the text of each place, b"" for none; a text instead: the name of the error of this line."""


class TextDecoder(LineDecoder):
    """Decodes lines of fields."""

    def __init__(self, codec: DescribedText, layout: Layout) -> None:
        self._layout = layout
        values = max([len(codec.places), *(getattr(each, "field", None) or 0 for each in codec.places)])
        super().__init__(
            codec,
            start=layout.start,
            marked=bool(layout.start) or layout.checksum != "none",
            longest=max(LONGEST, OF_A_VALUE * values),
        )

    def _texts(self, line: bytes) -> Sequence[bytes] | str:
        """See `LineDecoder`; a line is wrong that is too short, or repeats a key."""
        layout, body = self._layout, line.removesuffix(b"\r")
        size, of = CHECKSUMS[layout.checksum]
        if size:
            body, _, digits = body.rpartition(layout.mark)
            if not re.fullmatch(rb"[0-9A-Fa-f]{%d}" % (2 * size), digits):
                return "format"
            if int(digits, 16) != of(body):
                return "crc"
        tokens = [each.strip() for each in body.split(None if layout.blanks else layout.separator)]
        pairs = [
            (key.strip(), text.strip()) for key, _, text in (each.partition(layout.equals) for each in tokens)
        ]
        keyed = dict(pairs)
        texts: list[bytes] = []
        for place in self._places:
            assert isinstance(place, TextValue)
            key = place.key.encode() if place.key is not None else b""
            if place.field is not None and place.field > len(tokens):
                return "format"
            if place.field is None and sum(each == key for each, _ in pairs) > 1:
                return "format"
            texts.append(tokens[place.field - 1] if place.field is not None else keyed.get(key, b""))
        return texts


def _raw(text: bytes, field: Field) -> float | str | None:
    """Return the raw value that a text says; None: it says none."""
    word = text.decode(errors="replace")
    if NUMBER.fullmatch(word):
        return float(word)
    if word in field.words:
        return word
    return TRUTH.get(word) if field.bits and not field.words else None


def _written(raw: float | str, place: Place) -> bytes:
    if isinstance(raw, str):
        return raw.encode()
    if place.decimals is not None:
        return b"%.*f" % (place.decimals, raw)
    return b"%.10g" % raw
