"""The interfaces of codecs: formats of frames on a wire. Pure: bytes in, frames out, no I/O, no clock."""

from __future__ import annotations

import builtins
from collections.abc import Mapping
from typing import ClassVar, NamedTuple, Protocol, TypeGuard

from end_effector_hal.signals import Frame, Kind, Value


class Decoder(Protocol):
    """Finds frames in a stream of bytes; keeps an unfinished frame, bounded in size."""

    @property
    def bytes(self) -> int:
        """Number of bytes fed."""
        ...

    @property
    def frames(self) -> int:
        """Number of frames returned."""
        ...

    @property
    def errors(self) -> Mapping[str, int]:
        """Counts of discarded data, by the names in ``docs/reference/channels.md``; ``noise`` counts bytes."""
        ...

    @property
    def lost(self) -> int:
        """Number of frames that are missing according to the sequence numbers."""
        ...

    @property
    def reboots(self) -> int:
        """Number of backward jumps of the sequence number or of the device's clock."""
        ...

    def feed(self, data: builtins.bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``, in order; never raises, for any bytes.

        Args:
            data: the bytes read, in pieces of any size.
            at: time of the read, µs; becomes the ``at`` of the frames.
        """
        ...


class Carrier(Protocol):
    """The properties of a source of readings that a detector needs; every `Codec` is a carrier.

    It may also have ``resolution_pa`` and ``sources``, see `sources_of`.
    """

    @property
    def name(self) -> str:
        """The name for messages."""
        ...

    @property
    def channels(self) -> Mapping[str, Kind]:
        """The kinds of its channels, by name."""
        ...

    @property
    def period_us(self) -> int:
        """Nominal time between two frames, µs; the longest one if there are several sources."""
        ...


class Codec(Carrier, Protocol):
    """A wire format. A channel that is not in ``channels`` is not fitted.

    It may also have ``parity`` and ``resolution_pa``; see `parity_of`, `resolution_of`.
    """

    @property
    def baudrate(self) -> int:
        """Baud rate, unless a description gives another; 8 bits, 1 stop bit, parity: see `parity_of`."""
        ...

    def decoder(self) -> Decoder:
        """Return a new decoder for one stream."""
        ...

    def encode(self, frame: Frame) -> bytes:
        """Return the bytes of a frame; a channel that is missing or None is sent as invalid if the format allows it.

        Raises:
            UsageError: a value does not fit the format.
        """
        ...


def parity_of(codec: Codec) -> str:
    """Return the codec's ``parity``: ``N``, ``E`` or ``O``; ``N`` if it has none."""
    return str(getattr(codec, "parity", "N"))


def resolution_of(codec: object) -> float:
    """Return the codec's ``resolution_pa``, the smallest step of a pressure in Pa; 1 if it has none."""
    return float(getattr(codec, "resolution_pa", 1))


FINE_PA = 50
"""Largest step of a codec that still shows the noise of a sensor, Pa; with larger steps no value counts as frozen."""


def shows_noise(codec: object) -> bool:
    """Return whether the codec's resolution is fine enough to distinguish a frozen sensor from a working one."""
    return resolution_of(codec) <= FINE_PA


class Polled(NamedTuple):
    """The result of `PolledDecoder.poll`.

    Attributes:
        data: a request to send now; b"": none yet.
        frames: frames that ended because an answer is missing.
    """

    data: bytes = b""
    frames: tuple[Frame, ...] = ()


class PolledDecoder(Decoder, Protocol):
    """A decoder that makes requests. Sans-IO: the reader of the port calls `poll` at ``due`` and sends the result."""

    @property
    def due(self) -> int:
        """Time of the next call of `poll`, µs: the next request is due, or an answer is overdue."""
        ...

    def poll(self, at: int) -> Polled:
        """Process the passing of time up to ``at`` (µs); has no effect before ``due``."""
        ...


class Device(Protocol):
    """The simulated device of a polled link, for a testbench."""

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """Return the answers to the requests that end in ``data``, in order; None is answered as invalid.

        Never raises, for any bytes; data that is not a request to this device gets no answer.
        """
        ...


class PolledCodec(Codec, Protocol):
    """A codec whose `decoder` returns a `PolledDecoder`; its `encode` returns all answers of one cycle."""

    def decoder(self) -> PolledDecoder:
        """Return a new decoder for one stream."""
        ...

    def device(self) -> Device:
        """Return a new simulated device for one stream."""
        ...


def is_polled(codec: Codec) -> TypeGuard[PolledCodec]:
    """Return whether the codec is polled: its decoder makes requests."""
    return hasattr(codec, "device")


def asks(decoder: Decoder) -> TypeGuard[PolledDecoder]:
    """Return whether the decoder is one of a polled codec."""
    return hasattr(decoder, "poll")


SEQ_BITS, CLOCK_BITS = 16, 32
"""Widths of the sequence number, and of the clock of a device in ms."""
SEQ_MOD, CLOCK_MOD = 1 << SEQ_BITS, 1 << CLOCK_BITS


class Sequence:
    """Checks the sequence numbers and the device clock of one stream; both wrap around.

    A backward jump by less than half of the range (of the number or of the clock) is a reboot of the device.
    """

    MEMORY: ClassVar = {"lost": int, "reboots": int, "_last": tuple[int, int] | None}
    """The attributes that change while frames arrive, for a recording that begins in the middle."""

    def __init__(self) -> None:
        self.lost = 0
        self.reboots = 0
        self._last: tuple[int, int] | None = None

    def is_new(self, seq: int, device_ms: int) -> bool:
        """Return whether this frame is to be delivered; False for a repeated number."""
        last, self._last = self._last, (seq, device_ms)
        if last is None:
            return True
        step = (seq - last[0]) % SEQ_MOD
        clock_back = (device_ms - last[1]) % CLOCK_MOD >= CLOCK_MOD // 2
        if step == 0 and not clock_back:
            self._last = last
            return False
        if clock_back or step >= SEQ_MOD // 2:
            self.reboots += 1
        else:
            self.lost += step - 1
        return True
