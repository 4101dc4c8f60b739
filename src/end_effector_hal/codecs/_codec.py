"""The codec: how frames stand on a wire. Pure: bytes in, frames out, no I/O, no clock."""

from __future__ import annotations

import builtins
from collections.abc import Mapping
from typing import ClassVar, NamedTuple, Protocol, TypeGuard

from end_effector_hal.signals import Frame, Kind, Value


class Decoder(Protocol):
    """Finds frames in a stream of bytes; remembers a part of a frame, bounded in size."""

    @property
    def bytes(self) -> int:
        """All bytes fed."""
        ...

    @property
    def frames(self) -> int:
        """Frames returned."""
        ...

    @property
    def errors(self) -> Mapping[str, int]:
        """What was thrown away, by the names of ``docs/reference/channels.md``; ``noise`` in bytes."""
        ...

    @property
    def lost(self) -> int:
        """Frames missing by their sequence numbers."""
        ...

    @property
    def reboots(self) -> int:
        """Jumps back of the sequence number or of the device's clock."""
        ...

    def feed(self, data: builtins.bytes, at: int) -> list[Frame]:
        """The frames that end in ``data``, in order; never raises, whatever the bytes.

        Args:
            data: what was read, in pieces of any size.
            at: µs, when it was read; becomes the ``at`` of the frames.
        """
        ...


class Carrier(Protocol):
    """What a detector needs to know of where its readings come from; every `Codec` is one.

    It may have more: ``resolution_pa``, ``seq_bits``, ``clock_bits`` and ``sources``, see `sources_of`.
    """

    @property
    def name(self) -> str:
        """For a sentence."""
        ...

    @property
    def channels(self) -> Mapping[str, Kind]:
        """What it carries."""
        ...

    @property
    def period_us(self) -> int:
        """Nominal time between two frames; of several sources, the longest."""
        ...


class Codec(Carrier, Protocol):
    """A wire format. A channel that is not in ``channels`` is not fitted.

    It may have more: ``parity``, ``resolution_pa``, ``seq_bits`` and ``clock_bits``; see `parity_of`,
    `resolution_of`, `sequence_of`.
    """

    @property
    def baudrate(self) -> int:
        """Of the line, unless a description gives another; 8 bits, 1 stop bit, parity as `parity_of` says."""
        ...

    def decoder(self) -> Decoder:
        """A new one, for one stream."""
        ...

    def encode(self, frame: Frame) -> bytes:
        """The bytes of a frame; a channel that is missing or None is sent as invalid where the format can.

        Raises:
            UsageError: a value does not fit the format.
        """
        ...


def parity_of(codec: Codec) -> str:
    """``N``, ``E`` or ``O``: what the codec has as ``parity``; one without it is sent without."""
    return str(getattr(codec, "parity", "N"))


def resolution_of(codec: object) -> float:
    """Pa of the smallest step of a pressure: what the codec has as ``resolution_pa``, else 1."""
    return float(getattr(codec, "resolution_pa", 1))


FINE_PA = 50
"""A codec that counts in larger steps does not show the noise of a sensor: no value is called frozen."""


def shows_noise(codec: object) -> bool:
    """Whether it counts finely enough to tell a frozen sensor from a living one."""
    return resolution_of(codec) <= FINE_PA


class Polled(NamedTuple):
    """What a call of `PolledDecoder.poll` leaves to do.

    Attributes:
        data: a request, to be sent now; b"": none yet.
        frames: those that ended because an answer did not come.
    """

    data: bytes = b""
    frames: tuple[Frame, ...] = ()


class PolledDecoder(Decoder, Protocol):
    """A decoder that asks. Sans-IO: the reader of the port calls `poll` at ``due`` and sends what it returns."""

    @property
    def due(self) -> int:
        """µs at which `poll` is to be called next: for the next request, or because an answer is overdue."""
        ...

    def poll(self, at: int) -> Polled:
        """Time has come to ``at`` (µs); before ``due`` it does nothing."""
        ...


class Device(Protocol):
    """The other end of a polled link, for a testbench."""

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """The answers to the requests that end in ``data``, in order; None is answered as invalid.

        Never raises, whatever the bytes; what is no request, or not for this device, is not answered.
        """
        ...


class PolledCodec(Codec, Protocol):
    """A codec whose `decoder` is a `PolledDecoder`; its `encode` gives all the answers of one cycle."""

    def decoder(self) -> PolledDecoder:
        """A new one, for one stream."""
        ...

    def device(self) -> Device:
        """A new one, for one stream."""
        ...


def is_polled(codec: Codec) -> TypeGuard[PolledCodec]:
    """Whether a codec has to ask."""
    return hasattr(codec, "device")


def asks(decoder: Decoder) -> TypeGuard[PolledDecoder]:
    """Whether a decoder is that of a polled codec."""
    return hasattr(decoder, "poll")


class Sequence:
    """Judges the sequence numbers and the device's clock of one stream; both wrap around.

    A jump back by less than half of the range (of the number or of the clock) is a reboot of the device.

    Args:
        seq_bits, clock_bits: their width.
    """

    MEMORY: ClassVar = {"lost": int, "reboots": int, "_last": tuple[int, int] | None}
    """What changes while frames come, for a recording that begins in the middle."""

    def __init__(self, *, seq_bits: int, clock_bits: int) -> None:
        self.lost = 0
        self.reboots = 0
        self._seq_mod, self._clock_mod = 1 << seq_bits, 1 << clock_bits
        self._last: tuple[int, int] | None = None

    def is_new(self, seq: int, device_ms: int) -> bool:
        """Whether this frame is to be delivered; a repeated number is not."""
        last, self._last = self._last, (seq, device_ms)
        if last is None:
            return True
        step = (seq - last[0]) % self._seq_mod
        clock_back = (device_ms - last[1]) % self._clock_mod >= self._clock_mod // 2
        if step == 0 and not clock_back:
            self._last = last
            return False
        if clock_back or step >= self._seq_mod // 2:
            self.reboots += 1
        else:
            self.lost += step - 1
        return True


def sequence_bits(codec: object) -> tuple[int, int]:
    """Of its sequence number and its clock: 16 and 32, unless it has other ``seq_bits`` and ``clock_bits``."""
    return getattr(codec, "seq_bits", 16), getattr(codec, "clock_bits", 32)


def sequence_of(seq_bits: int, clock_bits: int) -> Sequence:
    """A new one, for frames with numbers of this width."""
    return Sequence(seq_bits=seq_bits, clock_bits=clock_bits)
