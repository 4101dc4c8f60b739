"""Digital inputs of real chips, found by name (libgpiod's v2 API, PyPI ``gpiod``)."""

from __future__ import annotations

import errno
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from heapq import merge
from typing import Any

from end_effector_hal.description import DigitalInput
from end_effector_hal.errors import WireError
from end_effector_hal.wires.lines import load_gpiod, open_chip
from end_effector_hal.wires.lines._gpiod import busy, chip_requests, find_lines

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
    """

    request: Any
    lines: Mapping[int, str]
    seqno: int = 0
    read_ns: int = 0

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
    """

    def __init__(self, pattern: str = "/dev/gpiochip*") -> None:
        self._pattern = pattern
        self._requests: list[_Request] = []

    def request(self, inputs: Mapping[str, DigitalInput]) -> None:
        """Claim the lines; see `InputLines.request`."""
        self._gpiod = load_gpiod()
        found = find_lines(self._gpiod, self._pattern, list(inputs))
        try:
            for path, offsets in chip_requests(found):
                claimed = self._claimed(path, offsets, inputs)
                self._requests.append(_Request(claimed, {at: name for name, at in offsets.items()}))
        except BaseException:
            self.close()
            raise

    def fds(self) -> list[int]:
        """Return the descriptor of each request."""
        return [each.request.fd for each in self._requests]

    def due(self) -> None:
        """Return None: the kernel debounces, and a descriptor reports every edge."""

    def edges(self) -> Edges:
        """Return the new edges with the kernel's times; a gap in their numbers means that some were overwritten."""
        found: list[list[LineEdge]] = []
        lost = False
        rising = self._gpiod.EdgeEvent.Type.RISING_EDGE
        for each in self._requests:
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
            each.read_ns = time.monotonic_ns()
            with self._working():
                values = each.request.get_values(list(each.lines))
            levels |= {name: value == active for name, value in zip(each.lines.values(), values, strict=True)}
        return levels

    def close(self) -> None:
        """Release the lines."""
        while self._requests:
            self._requests.pop().request.release()

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
                raise WireError(
                    f"the input lines {', '.join(offsets)} cannot be claimed: {error.strerror}.",
                    where=path,
                    todo="The chip may give no edges, or have no such bias: use other lines, or bias: as_is.",
                ) from error

    def _settings(self, wanted: DigitalInput) -> Any:
        line = self._gpiod.line
        return self._gpiod.LineSettings(
            direction=line.Direction.INPUT,
            edge_detection=line.Edge.BOTH,
            bias=getattr(line.Bias, wanted.bias.upper()),
            debounce_period=timedelta(milliseconds=wanted.debounce_ms),
            event_clock=line.Clock.MONOTONIC,
        )
