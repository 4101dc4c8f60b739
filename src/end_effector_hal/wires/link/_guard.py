"""Between a link and a decoder: every answer is checked before anybody else sees it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice
from typing import cast

from end_effector_hal.codecs import (
    Codec,
    Counters,
    Polled,
    PolledDecoder,
    asks,
    counters_of,
    frame_fault,
    weight,
)
from end_effector_hal.signals import Frame
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.link._codec_calls import CodecCalls

MOST_KEPT = 65_536
"""Bytes and elements that a decoder may keep between two calls."""
LONGEST_REQUEST = 4_096
"""Bytes that `poll` may ask to be sent."""
MOST_ENDED = 64
"""Frames that one `poll` may end."""
LEAST_WAIT_US, LONGEST_WAIT_US = 1_000, 1_000_000


class GuardedDecoder:
    """A decoder whose answers have the right type and size, and whose frames have stamps and values that can be.

    What it keeps is measured, so that it is given up before it fills the memory.

    Args:
        codec: makes the decoder.
        calls: all calls into the codec go through this.

    Raises:
        CodecFailure: the codec failed. So does every method.
    """

    def __init__(self, codec: Codec, calls: CodecCalls) -> None:
        self._calls, self._codec = calls, codec
        self._kinds = calls.run("channels", lambda: dict(codec.channels))
        self._decoder = calls.run("decoder()", codec.decoder)
        self.asks = calls.run("decoder()", lambda: asks(self._decoder))
        self._idle = False
        self._last = 0
        self.counters = self._count()

    def feed(self, data: bytes) -> list[Frame]:
        """The frames that end in what was just read."""
        at = now_us()
        return self._frames("feed()", lambda: self._decoder.feed(data, at), len(data))

    def poll(self) -> Polled:
        """What is to be sent now, and the frames that ended for want of an answer; of one that asks."""
        poller = cast("PolledDecoder", self._decoder)
        data, frames = self._calls.run("poll()", lambda: Polled(*poller.poll(now_us())))
        if type(data) is not bytes or len(data) > LONGEST_REQUEST:
            raise self._calls.failure(
                f"poll() returned something else than at most {LONGEST_REQUEST} bytes to send"
            )
        ended = self._frames("poll()", lambda: frames, MOST_ENDED)
        self._idle = not data and not ended
        return Polled(data, tuple(ended))

    def wait_s(self) -> float | None:
        """Seconds until it wants to ask; None: never. One that wants to at once, and does not ask, is made to wait."""
        if not self.asks:
            return None
        due = self._calls.run("due", lambda: cast("PolledDecoder", self._decoder).due)
        if type(due) is not int:
            raise self._calls.failure("due is no whole number of microseconds")
        least = LEAST_WAIT_US if self._idle else 0
        return min(max(least, due - now_us()), LONGEST_WAIT_US) / 1_000_000

    def _frames(self, what: str, call: Callable[[], Iterable[Frame]], most: int) -> list[Frame]:
        frames = self._calls.run(what, lambda: list(islice(iter(call()), most + 1)))
        if len(frames) > most:
            raise self._calls.failure(f"{what} returned more than {most} frames")
        now = now_us()
        for frame in frames:
            if wrong := frame_fault(frame, self._kinds, self._last, now):
                raise self._calls.failure(f"{what} returned {wrong}")
            self._last = frame.at
        self.counters = self._count()
        if (kept := self._calls.run("attributes", lambda: weight(self._decoder, self._codec))) > MOST_KEPT:
            raise self._calls.failure(f"its decoder keeps {kept} bytes, at most {MOST_KEPT} are allowed")
        return frames

    def _count(self) -> Counters:
        counters = self._calls.run("counters", lambda: counters_of(self._decoder))
        if counters is None:
            raise self._calls.failure("its counters are no whole numbers by name")
        return counters
