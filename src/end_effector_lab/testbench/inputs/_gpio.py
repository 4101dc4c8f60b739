"""Real lines as inputs: the testbench on a Raspberry Pi (libgpiod's v2 API)."""

from __future__ import annotations

import errno
import glob
import os
import select
import threading
from collections.abc import Mapping
from typing import Any

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.wires.lines import load_gpiod

from ._inputs import OnEdge

CONSUMER = "end-effector-testbench"


class GpioInputs:
    """Reports edges of real lines, with time stamps of the kernel.

    Args:
        lines: line of the description -> name of the line on this machine.
        text: name of the inputs for people.
        pattern: paths of the chips.
    """

    def __init__(self, lines: Mapping[str, str], text: str, pattern: str = "/dev/gpiochip*") -> None:
        self.text = text
        self.lines, self._pattern = dict(lines), pattern
        self._requests: dict[int, tuple[Any, dict[int, str]]] = {}
        self._thread: threading.Thread | None = None

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        self._gpiod = load_gpiod()
        levels: dict[str, bool] = {}
        for path, offsets in self._find().items():
            request = self._request(path, offsets)
            self._requests[request.fd] = request, offsets
            values = request.get_values(list(offsets))
            active = self._gpiod.line.Value.ACTIVE
            levels |= {line: value == active for line, value in zip(offsets.values(), values, strict=True)}
        self._wake_read, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, args=(on_edge,), name="lines", daemon=True)
        self._thread.start()
        return levels

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is not None:
            os.write(self._wake, b"x")
            thread.join()
            os.close(self._wake)
            os.close(self._wake_read)
        while self._requests:
            self._requests.popitem()[1][0].release()

    def _run(self, on_edge: OnEdge) -> None:
        rising = self._gpiod.EdgeEvent.Type.RISING_EDGE
        while True:
            ready, _, _ = select.select([*self._requests, self._wake_read], [], [])
            if self._wake_read in ready:
                return
            for fd in ready:
                request, offsets = self._requests[fd]
                for event in request.read_edge_events():
                    at = event.timestamp_ns // 1000
                    on_edge(offsets[event.line_offset], event.event_type == rising, at)

    def _find(self) -> dict[str, dict[int, str]]:
        """Return chip -> offset -> line of the description."""
        here: dict[str, list[tuple[str, int]]] = {}
        chips = [path for path in sorted(glob.glob(self._pattern)) if self._gpiod.is_gpiochip_device(path)]
        for path in sorted({os.path.realpath(path) for path in chips}):
            with self._open(path) as chip:
                for offset in range(chip.get_info().num_lines):
                    here.setdefault(chip.get_line_info(offset).name, []).append((path, offset))
        found: dict[str, dict[int, str]] = {}
        for line, name in self.lines.items():
            places = here.get(name, [])
            if len(places) != 1:
                raise LineNotFoundError(
                    f"the line {name} ({line}) is on {len(places) or 'no'} GPIO chip(s) of this machine, not on one.",
                    where=self._pattern,
                    todo="gpioinfo lists the lines; --lines gpiod:LINE=NAME,... names others.",
                )
            path, offset = places[0]
            found.setdefault(path, {})[offset] = line
        return found

    def _open(self, path: str) -> Any:
        try:
            return self._gpiod.Chip(path)
        except OSError as error:
            raise _refused(path, error) from error

    def _request(self, path: str, offsets: Mapping[int, str]) -> Any:
        """Request the lines as inputs with edge events; pulled down, so that a disconnected wire is inactive."""
        line = self._gpiod.line
        settings = self._gpiod.LineSettings(
            direction=line.Direction.INPUT,
            edge_detection=line.Edge.BOTH,
            bias=line.Bias.PULL_DOWN,
            event_clock=line.Clock.MONOTONIC,
        )
        try:
            return self._gpiod.request_lines(path, consumer=CONSUMER, config={tuple(offsets): settings})
        except OSError as error:
            raise _refused(path, error) from error


def _refused(path: str, error: OSError) -> WireError:
    todo = {
        errno.EACCES: "Add the user to the group gpio and log in again.",
        errno.EBUSY: "gpioinfo shows who holds a line: stop that program.",
    }.get(error.errno or 0, "The controller gives no edges of these lines: use others, or see dmesg.")
    return WireError(f"the GPIO lines cannot be used: {error.strerror}.", where=path, todo=todo)
