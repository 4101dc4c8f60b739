"""A stand-in for the kernel's GPIO chips, as far as the testbench's inputs use gpiod."""

from __future__ import annotations

import os
from enum import Enum
from types import SimpleNamespace
from typing import Any


class Kind(Enum):
    RISING_EDGE = 1
    FALLING_EDGE = 2


class Kernel:
    """Two chips; a request is a pipe."""

    api_version = "2.2.1"

    def __init__(self, names: dict[str, list[str]] | None = None) -> None:
        self.names = names or {"/dev/null": ["", "GPIO19", "GPIO16"], "/dev/zero": ["GPIO26", "TWIN", "TWIN"]}
        value = SimpleNamespace(ACTIVE="active", INACTIVE="inactive")
        self.line = SimpleNamespace(
            Value=value,
            Direction=SimpleNamespace(INPUT="input"),
            Edge=SimpleNamespace(BOTH="both"),
            Bias=SimpleNamespace(PULL_DOWN="down"),
            Clock=SimpleNamespace(MONOTONIC="monotonic"),
        )
        self.EdgeEvent = SimpleNamespace(Type=Kind)
        self.LineSettings = lambda **settings: settings
        self.requests: dict[str, Request] = {}
        self.active: set[tuple[str, int]] = set()
        self.busy = False

    def is_gpiochip_device(self, path: str) -> bool:
        return path in self.names

    def Chip(self, path: str) -> Any:
        return Chip(self.names[path])

    def request_lines(self, path: str, *, consumer: str, config: dict[tuple[int, ...], Any]) -> Request:
        if self.busy:
            raise OSError(16, "Device or resource busy")
        ((_, settings),) = config.items()
        assert settings == {
            "direction": "input",
            "edge_detection": "both",
            "bias": "down",
            "event_clock": "monotonic",
        }
        self.requests[path] = Request(self, path)
        return self.requests[path]


class Chip:
    def __init__(self, names: list[str]) -> None:
        self._names = names

    def __enter__(self) -> Chip:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def get_info(self) -> Any:
        return SimpleNamespace(label="", num_lines=len(self._names))

    def get_line_info(self, offset: int) -> Any:
        return SimpleNamespace(name=self._names[offset])


class Request:
    def __init__(self, kernel: Kernel, path: str) -> None:
        self._kernel, self._path = kernel, path
        self.fd, self._write = os.pipe()
        self._events: list[Any] = []
        self.released = False

    def get_values(self, offsets: list[int]) -> list[str]:
        return ["active" if (self._path, offset) in self._kernel.active else "inactive" for offset in offsets]

    def happen(self, offset: int, kind: Kind, at_us: int) -> None:
        self._events.append(SimpleNamespace(line_offset=offset, event_type=kind, timestamp_ns=at_us * 1000))
        os.write(self._write, b"e")

    def read_edge_events(self) -> list[Any]:
        os.read(self.fd, 1)
        return [self._events.pop(0)]

    def release(self) -> None:
        os.close(self.fd)
        os.close(self._write)
        self.released = True
