"""Digital inputs of real chips (libgpiod's v2 API, PyPI ``gpiod``)."""

from __future__ import annotations

import errno
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import timedelta
from heapq import merge
from typing import Any

from end_effector_hal.description import DigitalInput
from end_effector_hal.errors import WireError
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.lines import chip_requests, find_lines, load_gpiod, open_chip
from end_effector_hal.wires.lines._gpiod import busy

from ._lines import Edges, LineEdge

INPUT_CONSUMER = "end-effector-hal inputs"
MOST_READ = 1024
"""Most edges read from a chip at a time, as many as the kernel keeps; further edges of a line that never rests wait."""


@dataclass
class _Request:
    """A request for some lines of a chip.

    Attributes:
        seqno: number of the last edge.
        read_ns: time at which the levels were read; they include all earlier edges.
        poll_us: period at which the levels are read, where the kernel reports no edges; else 0.
        values: the levels that were read last, by offset.
    """

    request: Any
    lines: Mapping[int, str]
    seqno: int = 0
    read_ns: int = 0
    poll_us: int = 0
    values: dict[int, Any] = field(default_factory=dict)

    @property
    def due_us(self) -> int:
        """Time of the next poll, µs."""
        return self.read_ns // 1000 + self.poll_us

    def read(self) -> dict[int, Any]:
        """Read the levels; raises OSError."""
        self.read_ns = time.monotonic_ns()
        return dict(zip(self.lines, self.request.get_values(list(self.lines)), strict=True))

    def events(self) -> Iterator[Any]:
        """Yield the waiting events; raises OSError."""
        read = 0
        while read < MOST_READ and self.request.wait_edge_events(0):
            events = self.request.read_edge_events()
            read += len(events)
            yield from events


class GpiodInputLines:
    """`InputLines` on ``/dev/gpiochip*``; one request for up to 64 inputs of a chip.

    Args:
        pattern: glob pattern of the chips.
        outputs: output lines of the same tool; an input that is one of them is refused: as an input it would drop.
    """

    def __init__(self, pattern: str = "/dev/gpiochip*", *, outputs: Sequence[str] = ()) -> None:
        self._pattern, self._outputs = pattern, outputs
        self._requests: list[_Request] = []

    def request(self, inputs: Mapping[str, DigitalInput]) -> None:
        """Claim the lines; see `InputLines.request`."""
        self._gpiod = load_gpiod()
        found = find_lines(self._gpiod, self._pattern, list(inputs), self._outputs)
        polled = {name: place for name, place in found.items() if inputs[name].poll_ms}
        told = {name: place for name, place in found.items() if name not in polled}
        try:
            for path, offsets in [*chip_requests(told), *chip_requests(polled)]:
                claimed = self._claimed(path, offsets, inputs)
                poll_us = min(1000 * (inputs[name].poll_ms or 0) for name in offsets)
                lines = {at: name for name, at in offsets.items()}
                self._requests.append(_Request(claimed, lines, poll_us=poll_us))
        except BaseException:
            self.close()
            raise

    def fds(self) -> list[int]:
        """Return the descriptor of each request whose edges the kernel reports."""
        return [each.request.fd for each in self._requests if not each.poll_us]

    def due(self) -> int | None:
        """Return the time of the next poll, µs; None: nothing is polled, and a descriptor reports every edge."""
        return min((each.due_us for each in self._requests if each.poll_us), default=None)

    def edges(self) -> Edges:
        """Return the new edges with the kernel's times; a gap in their numbers means that some were overwritten."""
        found: list[list[LineEdge]] = []
        lost = False
        rising = self._gpiod.EdgeEvent.Type.RISING_EDGE
        for each in self._requests:
            if each.poll_us:
                found.append(self._polled(each))
                continue
            of_chip: list[LineEdge] = []
            with self._working():
                for event in each.events():
                    lost |= event.global_seqno != each.seqno + 1
                    each.seqno = event.global_seqno
                    if event.timestamp_ns >= each.read_ns:
                        line, high = each.lines[event.line_offset], event.event_type == rising
                        of_chip.append(LineEdge(event.timestamp_ns // 1000, line, high))
            found.append(of_chip)
        return Edges(list(merge(*found, key=lambda edge: edge.at)), lost)

    def levels(self) -> dict[str, bool]:
        """Return the levels as debounced and read by the kernel."""
        active = self._gpiod.line.Value.ACTIVE
        levels: dict[str, bool] = {}
        for each in self._requests:
            with self._working():
                each.values = each.read()
            levels |= {each.lines[offset]: value == active for offset, value in each.values.items()}
        return levels

    def close(self) -> None:
        """Release the lines."""
        while self._requests:
            self._requests.pop().request.release()

    def _polled(self, each: _Request) -> list[LineEdge]:
        """Read the levels if it is time; return an edge for each that is not as it was read last."""
        if now_us() < each.due_us:
            return []
        before = each.values
        with self._working():
            each.values = each.read()
        active, at = self._gpiod.line.Value.ACTIVE, each.read_ns // 1000
        return [
            LineEdge(at, each.lines[offset], value == active)
            for offset, value in each.values.items()
            if before and before[offset] != value
        ]

    @contextmanager
    def _working(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise WireError(
                f"the input lines do not work any more: {error.strerror}.",
                where=self._pattern,
                todo="The GPIO chip has gone, or its driver fails: see dmesg. "
                "They are claimed again as soon as it is back.",
            ) from error

    def _claimed(self, path: str, offsets: Mapping[str, int], inputs: Mapping[str, DigitalInput]) -> Any:
        config = {offset: self._settings(inputs[name]) for name, offset in offsets.items()}
        with open_chip(self._gpiod, path) as chip:
            try:
                return chip.request_lines(config=config, consumer=INPUT_CONSUMER)
            except OSError as error:
                if error.errno == errno.EBUSY:
                    raise busy(chip, path, offsets) from error
                if error.errno == errno.ENXIO and not all(inputs[name].poll_ms for name in offsets):
                    raise WireError(
                        f"the chip reports no edges of the input lines {', '.join(offsets)}.",
                        where=path,
                        todo="Write poll_ms: 10 into the digital: of each: they are read this often then.",
                    ) from error
                raise WireError(
                    f"the input lines {', '.join(offsets)} cannot be claimed: {error.strerror}.",
                    where=path,
                    todo="The chip may have no such bias: use other lines, or bias: as_is.",
                ) from error

    def _settings(self, wanted: DigitalInput) -> Any:
        line = self._gpiod.line
        return self._gpiod.LineSettings(
            direction=line.Direction.INPUT,
            edge_detection=line.Edge.NONE if wanted.poll_ms else line.Edge.BOTH,
            bias=getattr(line.Bias, wanted.bias.upper()),
            debounce_period=timedelta(milliseconds=wanted.debounce_ms),
            event_clock=line.Clock.MONOTONIC,
        )
