"""Guards a link against its codec and its device.

A codec may be third-party code: any exception in it becomes a `CodecFailure`. The rate of readings is compared with the
expected rate: this detects lost samples, and devices slower than declared.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import islice
from typing import TypeVar, cast

from end_effector_hal.codecs import (
    OWN_DECODERS,
    Codec,
    Counters,
    Polled,
    PolledDecoder,
    asks,
    counters_of,
    frame_fault,
)
from end_effector_hal.errors import LinkError
from end_effector_hal.plugins import named
from end_effector_hal.signals import Frame
from end_effector_hal.wires._clock import now_us

WINDOW_US, PERIODS = 1_000_000, 20
"""Length of a counting window: the longer of ``WINDOW_US`` and this number of periods."""
LEAST = 2 / 3
"""Least share of the expected samples of a channel. Two consecutive windows below it start an alarm; one window that
reaches it ends the alarm.
"""
LONGEST_MS = 10_000


class ArrivalWatch:
    """Counts the valid readings of each channel; sans-IO.

    Args:
        period_us: nominal time between two frames.
        declared: whether the description gives the period.
        asked: whether the devices are polled: a cycle may then take longer, and only readings missing in a frame
            count.
    """

    def __init__(self, period_us: int, *, declared: bool, asked: bool) -> None:
        self._period_us, self._declared, self._asked = period_us, declared, asked
        self._window_us = max(WINDOW_US, PERIODS * period_us)
        self._since, self._frames = -1, 0
        self._came: dict[tuple[str, ...], int] = {}  # frames by their valid channels
        self._few, self._lossy = frozenset[str](), frozenset[str]()
        self.text = ""
        """The present loss, as a sentence that stays as it was at the start of the alarm; empty: no loss."""

    def take(self, frame: Frame) -> None:
        """Count one more frame."""
        span_us = frame.at - self._since
        if self._since >= 0:
            self._frames += 1
            valid = tuple(frame.values)
            if None in frame.values.values():
                valid = tuple([name for name in valid if frame.values[name] is not None])
            self._came[valid] = self._came.get(valid, 0) + 1
            if span_us < self._window_us:
                return
            self._judge(span_us)
        self._since, self._frames, self._came = frame.at, 0, {}

    def _judge(self, span_us: int) -> None:
        expected = self._frames if self._asked else span_us / self._period_us
        came = Counter(name for valid, count in self._came.items() for name in valid * count)
        few = frozenset(name for name, count in came.items() if count < LEAST * expected)
        before, self._lossy, self._few = self._lossy, few & self._few, few
        if self._lossy == before:
            return
        each_ms, names = round(span_us / self._frames / 1000), ", ".join(sorted(self._lossy))
        self.text = names and f"More than a third of the samples of {names} are lost: is a wire loose?"
        if names and not self._asked and self._lossy >= came.keys():
            fits = f": set period_ms: {each_ms}" if self._declared and each_ms <= LONGEST_MS else ""
            expected_ms = f"{self._period_us / 1000:g} ms"
            self.text = (
                f"A frame comes every {each_ms} ms, not every {expected_ms}. "
                f"Either samples are lost, or the device is slower{fits}."
            )


T = TypeVar("T")
HUNG_US = 1_000_000
"""Longest time of a call, µs. A longer call has failed; until it returns, the link is down."""
TODO = "A new decoder is started; report this to the author of the codec."


class CodecFailure(LinkError):
    """The codec of a link raised an exception or returned a result that is not allowed."""


class CodecCalls:
    """Makes calls into a codec, one at a time. A call that does not return cannot be ended, only reported.

    Args:
        where: the port, for messages.
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self.name = "the codec"
        self._busy: tuple[str, int] | None = None

    @property
    def hung(self) -> tuple[str, int] | None:
        """A sentence about a call that has not returned for too long, and its start, µs; readable from any thread."""
        busy = self._busy
        if busy is None or (lasts := now_us() - busy[1]) < HUNG_US:
            return None
        what = f"{self.name} has not returned from {busy[0]} for {lasts // 1_000_000} s."
        todo = "Nothing is read until it does; report it to the author of the codec."
        return str(LinkError(what, where=self._where, todo=todo)), busy[1]

    def run(self, what: str, function: Callable[[], T]) -> T:
        """Call the function; raises CodecFailure for any exception, and if the call took too long."""
        self._busy = (what, begun := now_us())
        try:
            result = function()
        except BaseException as error:  # SystemExit as well: it would end a thread in silence
            if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
                raise
            raise self.failure(f"{what} raised {named(error)}") from error
        finally:
            self._busy = None
        if (took := now_us() - begun) >= HUNG_US:
            raise self.failure(f"{what} took {took / 1e6:.1f} s")
        return result

    def failure(self, what: str) -> CodecFailure:
        """Return the error for a failure of the codec."""
        return CodecFailure(f"{self.name} failed: {what}.", where=self._where, todo=TODO)


LONGEST_REQUEST = 4_096
"""Most bytes that `poll` may return to be sent."""
MOST_ENDED = 64
"""Most frames that one `poll` may return."""
LEAST_WAIT_US, LONGEST_WAIT_US = 1_000, 1_000_000


class GuardedDecoder:
    """A decoder whose results are checked: their type and size, and the stamps and values of the frames.

    A decoder of this distribution that is not polled is not checked: its tests do that, and a check takes longer than
    the decoding.

    Args:
        codec: makes the decoder.
        calls: makes all calls into the codec.

    Raises:
        CodecFailure: the codec failed; all methods raise it too.
    """

    def __init__(self, codec: Codec, calls: CodecCalls) -> None:
        self._calls, self._codec = calls, codec
        self._kinds = calls.run("channels", lambda: dict(codec.channels))
        self._decoder = calls.run("decoder()", codec.decoder)
        self.asks = calls.run("decoder()", lambda: asks(self._decoder))
        self._period_us = calls.run("period_us", lambda: int(codec.period_us))
        self._idle = False
        self._last = 0
        self._ours = type(self._decoder) in OWN_DECODERS
        self._counters = self._count()
        self._says = calls.run("faults", lambda: hasattr(self._decoder, "faults"))
        self.faults: tuple[str, ...] = ()
        """Faults in the received data, sentences: those that the decoder reports, and lost samples."""
        self._arrivals = ArrivalWatch(
            self._period_us, declared=hasattr(codec, "least_period_us"), asked=self._says
        )

    def feed(self, data: bytes, looked_at: int | None = None) -> list[Frame]:
        """Return the frames that end in the data just read, stamped with their arrival times; see `spread_stamps`.

        Args:
            data: the bytes read.
            looked_at: last time at which no data was available, µs; default: a moment ago.
        """
        at = now_us()
        if self._ours:
            frames = self._calls.run("feed()", lambda: self._decoder.feed(data, at))
            for frame in frames:
                self._arrivals.take(frame)
            self.faults = (self._arrivals.text,) if self._arrivals.text else ()
        else:
            frames = self._frames("feed()", lambda: self._decoder.feed(data, at), len(data))
        return spread_stamps(frames, at, 0 if looked_at is None else at - looked_at, self._period_us)

    @property
    def counters(self) -> Counters:
        """The counters of the decoder; may be read from any thread."""
        return counters_of(self._decoder) or self._counters if self._ours else self._counters

    def poll(self) -> Polled:
        """Return the data to send, and the frames that ended because an answer is missing; for polled decoders only."""
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
        """Return the time until the next request, s; None: there is none.

        A decoder that is always due but sends nothing has to wait a little.
        """
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
            self._arrivals.take(frame)
        self._counters = self._count()
        said = self._calls.run("faults", self._said) if self._says else ()
        self.faults = (*said, self._arrivals.text) if self._arrivals.text else said
        return frames

    def _said(self) -> tuple[str, ...]:
        texts: Iterable[object] = getattr(self._decoder, "faults", ())
        return tuple([text[:400] for text in islice(texts, MOST_ENDED) if isinstance(text, str)])

    def _count(self) -> Counters:
        counters = self._calls.run("counters", lambda: counters_of(self._decoder))
        if counters is None:
            raise self._calls.failure("its counters are no whole numbers by name")
        return counters


STANDSTILL_US = 500_000
"""Pause of the reader after which the arrival times of the frames are unknown, µs."""


def spread_stamps(frames: list[Frame], at: int, away_us: int, period_us: int) -> list[Frame]:
    """Give frames that were read together the times at which they arrived, as far as these are known.

    After a pause, a process finds the frames that waited for it. If they fill the pause, they arrived evenly. If there
    are fewer, the link was silent before or after them, and it is unknown which: they get the oldest possible time.

    Args:
        frames: the frames of one read, in order; frames with a stamp of their own keep it.
        at: the time of this read, µs.
        away_us: time since the last look at the port that found no data, µs.
        period_us: time between two frames, µs.
    """
    count = len(frames)
    known = away_us < STANDSTILL_US or 2 * count * period_us >= away_us
    if count == 1 and known:
        return frames
    step_us = min(away_us // max(1, count), max(0, period_us))
    return [
        replace(frame, at=at - (behind * step_us if known else away_us)) if frame.at == at else frame
        for behind, frame in zip(range(count - 1, -1, -1), frames, strict=True)
    ]
