"""Codecs of links on which a device speaks only when it is asked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol, TypeGuard

from end_effector_hal.codecs._codec import Codec, Decoder
from end_effector_hal.signals import Frame, Value


class Polled(NamedTuple):
    """What a call of `PolledDecoder.poll` leaves to do.

    Attributes:
        data: a request, to be sent now; b"": none yet.
        frames: those that ended because an answer did not come.
    """

    data: bytes = b""
    frames: tuple[Frame, ...] = ()


class PolledDecoder(Decoder, Protocol):
    """A decoder that asks. Sans-IO: whoever reads the port calls `poll` at ``due`` and sends what it returns."""

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
