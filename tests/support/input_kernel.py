"""A stand-in for the kernel's GPIO chips as input lines are read from them; events and settings are gpiod's own."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gpiod
from gpiod.edge_event import EdgeEvent

RISING, FALLING = 1, 2
KEPT = 16


class InputKernel:
    """Chips in a folder, by the names of their lines; ``/dev/gpiochip*`` of a test."""

    line, LineSettings, EdgeEvent, api_version = gpiod.line, gpiod.LineSettings, gpiod.EdgeEvent, "2.3"

    def __init__(self, folder: Path, **chips: list[str]) -> None:
        self.chips = {str(folder / name): _Chip(self, lines) for name, lines in chips.items()}
        for path in self.chips:
            Path(path).touch()
        self.pattern = f"{folder}/*"

    def is_gpiochip_device(self, path: str) -> bool:
        return path in self.chips

    def Chip(self, path: str) -> _Chip:
        return self.chips[path]

    def chip_of(self, line: str) -> _Chip:
        return next(chip for chip in self.chips.values() if line in chip.names)

    def drive(self, line: str, high: bool, at_ns: int | None = None) -> None:
        """The pin changes; the kernel stamps it and keeps the event if somebody asked for edges."""
        self.chip_of(line).drive(line, high, time.monotonic_ns() if at_ns is None else at_ns)


class _Chip:
    def __init__(self, kernel: InputKernel, names: list[str]) -> None:
        self.kernel, self.names = kernel, names
        self.label, self.edges = "", True
        self.high = dict.fromkeys(names, False)
        self.held_by: dict[int, str] = {}
        self.gone = False
        self.request: _Request | None = None

    def __enter__(self) -> _Chip:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def get_info(self) -> Any:
        return SimpleNamespace(label=self.label, num_lines=len(self.names))

    def get_line_info(self, offset: int) -> Any:
        consumer = self.held_by.get(offset, "")
        return SimpleNamespace(
            name=self.names[offset],
            used=bool(consumer),
            consumer=consumer,
            direction=gpiod.line.Direction.INPUT,
        )

    def request_lines(self, config: dict[int, gpiod.LineSettings], consumer: str) -> _Request:
        if self.gone:
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        if not self.edges and any(each.edge_detection != gpiod.line.Edge.NONE for each in config.values()):
            raise OSError(errno.ENXIO, os.strerror(errno.ENXIO))
        if any(offset in self.held_by for offset in config):
            raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))
        self.held_by |= dict.fromkeys(config, consumer)
        self.request = _Request(self, config)
        return self.request

    def drive(self, line: str, high: bool, at_ns: int) -> None:
        self.high[line] = high
        offset = self.names.index(line)
        if self.request and offset in self.request.config and self.edges:
            self.request.event(RISING if high else FALLING, at_ns, offset)


class _Request:
    def __init__(self, chip: _Chip, config: dict[int, gpiod.LineSettings]) -> None:
        self.chip, self.config = chip, config
        self.fd, self._write = os.pipe()
        self.events: list[EdgeEvent] = []
        self._seqno = 0

    def event(self, kind: int, at_ns: int, offset: int) -> None:
        self._seqno += 1
        self.events.append(EdgeEvent(kind, at_ns, offset, self._seqno, self._seqno))
        if len(self.events) > KEPT * len(self.config):
            del self.events[0]
        else:
            os.write(self._write, b"e")

    def wait_edge_events(self, timeout: float) -> bool:
        self._check()
        return bool(self.events)

    def read_edge_events(self) -> list[EdgeEvent]:
        self._check()
        events, self.events = self.events[:8], self.events[8:]
        os.read(self.fd, len(events))
        return events

    def get_values(self, offsets: list[int]) -> list[Any]:
        self._check()
        value = gpiod.line.Value
        return [value.ACTIVE if self.chip.high[self.chip.names[at]] else value.INACTIVE for at in offsets]

    def release(self) -> None:
        os.close(self.fd)
        os.close(self._write)
        self.chip.request = None
        for offset in self.config:
            self.chip.held_by.pop(offset, None)

    def _check(self) -> None:
        if self.chip.gone:
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
