"""Binary records of a fixed length: after start bytes, or between the delimiters of COBS or SLIP."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from cobs import cobs

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.codecs.described._codec import DescribedCodec, DescribedDecoder, SerialLine, by_place
from end_effector_hal.codecs.described._field import CHECKSUMS, Field, RawType
from end_effector_hal.description import Channel, RecordFrame, RecordValue
from end_effector_hal.signals import Frame

DELIMITERS = {"cobs": b"\0", "slip": b"\xc0"}
_SLIP = re.compile(rb"(?:[^\xdb\xc0]|\xdb[\xdc\xdd])*")


@dataclass(frozen=True)
class RecordLayout:
    """The layout of a record."""

    frame: RecordFrame
    places: tuple[RecordValue, ...]
    fields: tuple[Field, ...]

    @property
    def start(self) -> bytes:
        """The bytes at the beginning of each record, for ``framing: start``."""
        return bytes.fromhex(self.frame.start or "")

    @property
    def size(self) -> int:
        """Size of a record with its checksum, bytes."""
        return self.frame.length + CHECKSUMS[self.frame.checksum].size

    @property
    def delimiter(self) -> bytes:
        """The delimiter between two records; empty: none."""
        return DELIMITERS.get(self.frame.framing, b"")

    @property
    def longest(self) -> int:
        """Largest size of a record on the wire without delimiters, bytes."""
        if self.frame.framing == "slip":
            return 2 * self.size
        return self.size + self.size // 254 + 1 if self.delimiter else len(self.start) + self.size

    def framed(self, data: bytes) -> bytes:
        """Return the bytes on the wire of a record with its checksum."""
        match self.frame.framing:
            case "cobs":
                return b"\0%s\0" % cobs.encode(data)
            case "slip":
                return b"\xc0" + data.replace(b"\xdb", b"\xdb\xdd").replace(b"\xc0", b"\xdb\xdc") + b"\xc0"
            case _:
                return self.start + data

    def unframed(self, part: bytes) -> bytes:
        """Return the record between two delimiters; empty: it is not valid."""
        if len(part) > self.longest:
            return b""
        if self.frame.framing == "slip":
            if not _SLIP.fullmatch(part):
                return b""
            return part.replace(b"\xdb\xdc", b"\xc0").replace(b"\xdb\xdd", b"\xdb")
        try:
            data: bytes = cobs.decode(part)
        except cobs.DecodeError:
            return b""
        return data

    def checksum(self, record: bytes) -> bytes:
        """Return the checksum of a record, in the declared byte order."""
        size, of = CHECKSUMS[self.frame.checksum]
        return of(record).to_bytes(size, self.frame.checksum_order) if size else b""


class DescribedRecord(DescribedCodec):
    """The codec of declared binary records.

    Args:
        frame: the format of the records.
        channels: the channels with their places in a record.
        line: settings of the link.
    """

    def __init__(self, frame: RecordFrame, channels: Mapping[str, Channel], line: SerialLine) -> None:
        places: dict[RecordValue, dict[str, Channel]] = by_place(channels, "record")
        fields = tuple(Field(group, _type(place).limits) for place, group in places.items())
        self._layout = RecordLayout(frame, tuple(places), fields)
        delimiters = 2 * len(self._layout.delimiter)
        shortest = self._layout.size + delimiters if delimiters else self._layout.longest
        super().__init__(channels, line, line.wire_us(shortest))

    def decoder(self) -> Decoder:
        """Return a new decoder."""
        layout = self._layout
        if layout.delimiter:
            return DelimitedDecoder(layout, self.period_us)
        kind = UnprovenStartDecoder if layout.frame.checksum == "none" else StartDecoder
        return kind(layout, self.period_us)

    def encode(self, frame: Frame) -> bytes:
        """Return one record; no bytes if a channel has no value and its type cannot encode that."""
        layout = self._layout
        record = bytearray(layout.frame.length)
        for place, field in zip(layout.places, layout.fields, strict=True):
            kind = _type(place)
            raw = field.raw(frame.values)
            raw = kind.none if raw is None else raw
            if raw is None:
                return b""
            size = kind.bits // 8
            for index, byte in enumerate(kind.word(raw).to_bytes(size, place.byte_order)):
                record[place.byte + index] |= byte
        return layout.framed(bytes(record) + layout.checksum(bytes(record)))


class RecordDecoder(DescribedDecoder):
    """Decodes records into frames."""

    def __init__(self, layout: RecordLayout, period_us: int) -> None:
        super().__init__(period_us)
        self._layout = layout

    def _decoded(self, data: bytes, at: int) -> Frame | None:
        """Return the frame of a record with its checksum; None: the checksum is wrong."""
        layout = self._layout
        record = data[: layout.frame.length]
        if layout.checksum(record) != data[layout.frame.length :]:
            return None
        raws = []
        for place in layout.places:
            kind = _type(place)
            word = int.from_bytes(record[place.byte : place.byte + kind.bits // 8], place.byte_order)
            raws.append(kind.raw(word))
        return self._frame(at, layout.fields, raws)


class DelimitedDecoder(RecordDecoder):
    """Keeps at most one unfinished record; a delimiter ends any unfinished record."""

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        *parts, rest = (self._rest + data).split(self._layout.delimiter)
        frames = [frame for part in parts if part and (frame := self._part(part, at))]
        # One byte too many is kept: it says that this is no record, however the bytes came in pieces.
        self._rest = rest[: self._layout.longest + 1]
        self.errors["noise"] += len(rest) - len(self._rest)
        return frames

    def _part(self, part: bytes, at: int) -> Frame | None:
        data = self._layout.unframed(part)
        if len(data) != self._layout.size:
            self.errors["format"] += 1
            return None
        frame = self._decoded(data, at)
        if frame is None:
            self.errors["crc"] += 1
        return frame


class StartDecoder(RecordDecoder):
    """Keeps less than one record; a record with a wrong checksum is searched for another start."""

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        self._rest += data
        return [*self._frames(at)]

    def _frames(self, at: int) -> Iterator[Frame]:
        start, rest = self._layout.start, self._rest
        size, first = len(start) + self._layout.size, 0
        while (begins := rest.find(start, first)) >= 0 and begins + size <= len(rest):
            self.errors["noise"] += begins - first
            frame = self._decoded(rest[begins + len(start) : begins + size], at)
            first = begins + (size if frame else 1)
            if frame:
                yield frame
            else:
                self.errors["crc"] += 1
        if begins < 0:  # a part of a start may stand at its end
            begins = max(first, len(rest) - len(start) + 1)
        self.errors["noise"] += begins - first
        self._rest = rest[begins:]


class UnprovenStartDecoder(RecordDecoder):
    """Decodes records without a checksum, whose start bytes may also occur in the data.

    Records are accepted only after `IN_A_ROW` records have followed each other, and only as long as each record begins
    at the end of the last one; less than `IN_A_ROW` records are kept.
    """

    IN_A_ROW = 3

    def __init__(self, layout: RecordLayout, period_us: int) -> None:
        super().__init__(layout, period_us)
        self._in_step = False

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        size = len(self._layout.start) + self._layout.size
        ended = (self.bytes + len(data)) // size - self.bytes // size
        self.bytes += len(data)
        if self._interrupted(at, ended):
            self._in_step = False
        self._rest += data
        return [*self._frames(at)]

    def _frames(self, at: int) -> Iterator[Frame]:
        start, size = self._layout.start, len(self._layout.start) + self._layout.size
        while True:
            if self._in_step and not start.startswith(self._rest[: len(start)]):
                self._in_step = False
            if not self._in_step and not self._found(start, size):
                return
            self._in_step = True
            if len(self._rest) < size:
                return
            record, self._rest = self._rest[len(start) : size], self._rest[size:]
            if frame := self._decoded(record, at):
                yield frame

    def _found(self, start: bytes, size: int) -> bool:
        """Return whether enough records follow each other; then only the last of them is kept."""
        rest, first = self._rest, 0
        while first < len(rest):
            heads = [rest[first + n * size :][: len(start)] for n in range(self.IN_A_ROW)]
            if all(map(start.startswith, heads)):
                break  # or they are not all here yet
            first += 1
        found = len(rest) - first >= self.IN_A_ROW * size
        thrown = first + (self.IN_A_ROW - 1) * size if found else first
        self.errors["noise"] += thrown
        self._rest = rest[thrown:]
        return found


def _type(place: RecordValue) -> RawType:
    return RawType(place.value_type, place.bitmask)
