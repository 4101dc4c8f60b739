"""A codec of somebody else's that works until it is told not to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from end_effector_hal.signals import Frame, Kind

Fault = Callable[["FaultyDecoder", bytes, int], Any]


class FaultyCodec:
    """Each byte is a frame; ``fault`` takes the place of `feed`, ``broken`` that of whatever has its name."""

    name = "faulty"
    period_us, baudrate = 20_000, 115_200

    def __init__(self) -> None:
        self.fault: Fault | None = None
        self.broken: dict[str, Callable[[], Any]] = {}
        self.decoders: list[FaultyDecoder] = []

    @property
    def channels(self) -> Mapping[str, Kind]:
        return self.asked("channels", {"bottom": Kind.PRESSURE, "locked": Kind.BIT})

    def decoder(self) -> FaultyDecoder:
        self.decoders.append(FaultyDecoder(self))
        return self.asked("decoder", self.decoders[-1])

    def encode(self, frame: Frame) -> bytes:
        return b"x"

    def asked(self, what: str, answer: Any) -> Any:
        return self.broken[what]() if what in self.broken else answer


class FaultyDecoder:
    """Of one stream."""

    def __init__(self, codec: FaultyCodec) -> None:
        self._codec = codec
        self.total = 0
        self.kept = bytearray()
        self.numbers: Counter[str] = Counter()

    @property
    def bytes(self) -> int:
        return self._codec.asked("bytes", self.total)

    @property
    def frames(self) -> int:
        return self._codec.asked("frames", self.total)

    @property
    def errors(self) -> Mapping[str, int]:
        return self._codec.asked("errors", self.numbers)

    lost = reboots = 0

    def feed(self, data: bytes, at: int) -> Any:
        self.total += len(data)
        if self._codec.fault:
            return self._codec.fault(self, data, at)
        return [Frame(at, None, None, {"bottom": byte, "locked": True}) for byte in data]


class AskingCodec(FaultyCodec):
    """The same, of a device that has to be asked."""

    def decoder(self) -> AskingDecoder:
        return AskingDecoder(self)

    def device(self) -> None:
        """It has none: there is no testbench here."""


class AskingDecoder(FaultyDecoder):
    """Asks at once, then each second."""

    def __init__(self, codec: FaultyCodec) -> None:
        super().__init__(codec)
        self.next = 0

    @property
    def due(self) -> int:
        return self._codec.asked("due", self.next)

    def poll(self, at: int) -> Any:
        if at < self.next:
            return (b"", ())
        self.next = at + 1_000_000
        return self._codec.asked("poll", (b"?", ()))
