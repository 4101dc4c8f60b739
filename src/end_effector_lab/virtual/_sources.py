"""The sources of readings in virtual time: streaming links, polled links, inputs of the board; frames that would change
nothing are skipped.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Protocol

from end_effector_hal.codecs import Codec, PolledCodec, asks, board_inputs, codec_of, is_polled, line_of
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame, Kind, Value
from end_effector_hal.wires.inputs import input_lines, pulls_of
from end_effector_lab.testbench import Bench, SensorBoard, carried

LOOK_US = 5_000
"""Interval at which inputs are checked for an edge, µs."""


class Source(Protocol):
    """A source of frames."""

    @property
    def due(self) -> int:
        """Time at which `frames` must be called, µs."""
        ...

    def frames(self, at: int) -> list[Frame]:
        """Return the frames that have arrived by ``at`` µs."""
        ...


class StreamedLink:
    """A device that sends by itself; a frame arrives at the instant of its measurement."""

    def __init__(self, description: Description, name: str, bench: Bench, start: int) -> None:
        self._bench, self._name = bench, name or None
        self._board = SensorBoard(description, bench, start, name)
        self._codec = self._board.codec
        self.period_us, self.decoder = self._codec.period_us, self._codec.decoder()
        self._is_exact = carries_exactly(self._codec)
        self.due = start

    def frames(self, at: int) -> list[Frame]:
        """See `Source`."""
        self.due = at + self.period_us
        sent = self._board.frame(at)
        return self.decoder.feed(sent.data, at) if sent.data else []

    def passing(self, at: int) -> Mapping[str, Value]:
        """Return the content of the frame at ``at`` (µs), which `quiet_until` predicted and which changes nothing."""
        self.due = at + self.period_us
        sample = self._bench.sample(at)
        return self._board.carried(sample) if self._is_exact else self._as_it_comes(sample)

    def pass_by(self, to: int, *, unheard: bool) -> None:
        """Skip the frames until ``to`` (µs) that nobody receives: ``unheard``, or while the link is silent."""
        while self.due <= to and self._bench.leaves_no_trace(self.due, self._name, unheard=unheard):
            self._board.count(self.due)
            self.due += self.period_us

    def quiet_until(self, at: int) -> int | None:
        """See `Bench.quiet_until`."""
        return self._bench.quiet_until(at, self._name)

    def corners(self, at: int, until: int) -> tuple[Mapping[str, Value], Mapping[str, Value]] | None:
        """Return the lowest and highest values of the frames until then; see `Bench.corners`."""
        found = self._bench.corners(at, until)
        if found is None:
            return None
        if self._is_exact:
            return self._board.carried(found[0]), self._board.carried(found[1])
        try:
            low, high = map(self._as_it_comes, found)
        except (UsageError, ValueError):  # the format cannot carry what is so near to its end
            return None
        return low, high

    def _as_it_comes(self, values: Mapping[str, Value]) -> Mapping[str, Value]:
        (frame,) = self._codec.decoder().feed(
            self._codec.encode(Frame(0, 0, 0, self._board.carried(values))), 0
        )
        return frame.values


def carries_exactly(codec: Codec) -> bool:
    """Return whether a codec transmits values exactly: neighbouring values stay distinct, at low and high values."""
    for many in (-60_000, 0, 99_990, 500_000):
        for more in range(10):
            values: dict[str, Value] = {
                name: bool(more % 2) if kind is Kind.BIT else many + more
                for name, kind in codec.channels.items()
            }
            try:
                (frame,) = codec.decoder().feed(codec.encode(Frame(0, 0, 0, values)), 0)
            except (UsageError, ValueError):
                return False
            if frame.values != values:
                return False
    return True


class PolledLink:
    """A device that answers requests; requests and answers take time on the wire."""

    def __init__(self, description: Description, name: str, bench: Bench, start: int) -> None:
        codec = codec_of(description, name)
        assert is_polled(codec)
        self._codec: PolledCodec = codec
        self._byte_us = 10 * 1_000_000 // line_of(description.links[name], codec)[0]
        self._board = SensorBoard(description, bench, start, name)
        self.decoder = codec.decoder()
        assert asks(self.decoder)
        self._coming: deque[tuple[int, bytes]] = deque()
        self._start = start

    @property
    def due(self) -> int:
        """See `Source`."""
        due = max(self.decoder.due, self._start)
        return min(due, self._coming[0][0]) if self._coming else due

    def frames(self, at: int) -> list[Frame]:
        """See `Source`."""
        found: list[Frame] = []
        while self._coming and self._coming[0][0] <= at:
            found += self.decoder.feed(self._coming.popleft()[1], at)
        if self.decoder.due <= at:
            polled = self.decoder.poll(at)
            found += polled.frames
            if polled.data:
                self._ask(polled.data, at)
        return found

    def _ask(self, request: bytes, at: int) -> None:
        sent = self._board.answer(request, at)
        if sent is not None and sent.data and not sent.reset:
            wire_us = (len(request) + len(sent.data)) * self._byte_us
            self._coming.append((at + wire_us + sent.late_us, sent.data))


class BoardInputSource:
    """Inputs of the board: read periodically, and at once after a level change."""

    def __init__(self, description: Description, names: frozenset[str], bench: Bench, start: int) -> None:
        self._description, self._bench = description, bench
        self._channels = {name: each for name, each in description.channels.items() if name in names}
        self._kinds = {name: each.kind for name, each in self._channels.items()}
        self._pulls = pulls_of(input_lines(description))
        inputs = board_inputs(description)
        self._period_us = inputs.period_us if inputs else LOOK_US
        self._next = self.due = start
        self._last: Mapping[str, Value] = {}

    def frames(self, at: int) -> list[Frame]:
        """See `Source`."""
        self.due = at + LOOK_US
        values, last = self._read(at), self._last
        self._last = values
        if at >= self._next:
            self._next = at + self._period_us
        else:
            values = {
                name: value
                for name, value in values.items()
                if self._channels[name].digital and last.get(name) != value
            }
        return [Frame(at, None, None, values)] if values else []

    def _read(self, at: int) -> dict[str, Value]:
        """Read the inputs: a sensor without a value leaves its line to its pull; while all are silent, lines keep
        their levels.
        """
        shown = carried(self._bench.sample(at), self._kinds, self._description)
        silent, read = self._bench.silent(at), dict[str, Value]()
        for name, channel in self._channels.items():
            value = shown.get(name)
            if channel.digital is None:
                read[name] = None if silent or value is None else channel.value(channel.raw(value))
            elif silent and name in self._last:
                read[name] = self._last[name]
            elif value is None:
                read[name] = channel.value(float(self._pulls[channel.digital.line] == "up"))
            else:
                read[name] = channel.value(channel.raw(value))
        return read


def sources_of_bench(description: Description, bench: Bench, start: int) -> Iterator[Source]:
    """Yield the links that are not commanded, and the board inputs that the program's process reads."""
    for name in (name for name in description.links if name not in description.buses):
        kind = PolledLink if is_polled(codec_of(description, name)) else StreamedLink
        yield kind(description, name, bench, start)
    own = {name for name, each in description.channels.items() if each.on_board}
    if mine := frozenset(own - description.arbiter_inputs):
        yield BoardInputSource(description, mine, bench, start)


def arbiter_source(description: Description, bench: Bench, start: int) -> BoardInputSource | None:
    """Return the inputs that the arbiter reads; None: there are none."""
    if not description.arbiter_inputs:
        return None
    return BoardInputSource(description, description.arbiter_inputs, bench, start)


FEW, MOST = 6, 50
"""Number of frames to look ahead: at first (as long as a reading stays fresh), and later at most."""
LEAST = 3
"""Smallest number of skipped frames; for fewer, looking ahead takes as long as playing them."""
AGAIN_AFTER = 2, 6
"""Number of frames before the next look ahead if a change is expected: at first, and later."""


class Leap:
    """Decides which frame of a tool's only link is played next; see `end_effector_hal.sensing.stays`.

    Args:
        description: the description of the tool.
        link: the link with the readings.
        stays: returns whether frames, given by their corners, the time of the first one, the period and their number,
            change nothing for the program.
    """

    def __init__(self, description: Description, link: StreamedLink, stays: Callable[..., bool]) -> None:
        self.link, self._changes_nothing, self._supply = link, stays, description.supply.channel
        self.forget()

    def forget(self) -> None:
        """Play the next frame, because the measured values or the receivers change."""
        self._stays_until, self._look_at, self._ahead, self._again = -1, self.link.due + 1, FEW, 0

    def next(self, at: int, limit: int) -> int:
        """Return the time of the next played frame, µs: at or before ``limit``, or the next frame after ``at``."""
        due, period = self.link.due, self.link.period_us
        if limit < due:
            return due
        if self._stays_until < due:
            if due < self._look_at:
                return due
            ahead = self._quiet(at)
            if ahead < LEAST:
                return due
            if not self._stays(at, ahead):
                self._look_at, self._ahead = due + AGAIN_AFTER[self._again] * period, FEW
                self._again = 1
                return due
            self._stays_until = due + (ahead - 1) * period
            self._ahead, self._again = MOST if ahead == self._ahead else FEW, 0
        return due + (min(limit, self._stays_until) - due) // period * period

    def covers(self, at: int) -> bool:
        """Return whether the frame at ``at`` µs changes nothing."""
        return at <= self._stays_until

    def _quiet(self, at: int) -> int:
        """Return the number of next frames before anything happens by itself."""
        until, first = self.link.quiet_until(at), self.link.due
        return self._ahead if until is None else min(self._ahead, (until - first) // self.link.period_us + 1)

    def _stays(self, at: int, ahead: int) -> bool:
        """Return whether the next ``ahead`` frames change nothing."""
        first, period = self.link.due, self.link.period_us
        corners = self.link.corners(at, first + (ahead - 1) * period)
        return corners is not None and self._changes_nothing(self._apart(*corners), first, period, ahead)

    def _apart(self, low: Mapping[str, Value], high: Mapping[str, Value]) -> tuple[Mapping[str, Value], ...]:
        """Return the lowest values with the highest supply, and the reverse, since pressures are compared with the
        supply.
        """
        if self._supply not in low:
            return low, high
        return {**low, self._supply: high[self._supply]}, {**high, self._supply: low[self._supply]}
