"""The Raspberry Pi's inputs, on a stand-in for the kernel: no GPIO chip is needed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from enum import Enum
from queue import Queue
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.testbench import GpioInputs
from end_effector_hal.testbench import _gpio_inputs as module


class Kind(Enum):
    RISING_EDGE = 1
    FALLING_EDGE = 2


class Kernel:
    """Two chips; a request is a pipe."""

    api_version = "2.2.1"
    names = {"/dev/null": ["", "GPIO19", "GPIO16"], "/dev/zero": ["GPIO26", "TWIN", "TWIN"]}  # noqa: RUF012

    def __init__(self) -> None:
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
        return SimpleNamespace(num_lines=len(self._names))

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


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Iterator[Kernel]:
    kernel = Kernel()
    monkeypatch.setattr(module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
    yield kernel
    assert all(request.released for request in kernel.requests.values())


def inputs(**lines: str) -> GpioInputs:
    return GpioInputs(lines, "test", "/dev/[nz]*")


def ignore(line: str, level: bool, at: int) -> None:
    pass


def test_levels_and_edges_of_lines_on_two_chips(kernel: Kernel) -> None:
    kernel.active = {("/dev/null", 2)}
    seen: Queue[tuple[str, bool, int]] = Queue()
    lines = inputs(changer="GPIO19", bottom="GPIO16", cylinder="GPIO26")
    levels = lines.start(lambda *edge: seen.put(edge))
    assert levels == {"changer": False, "bottom": True, "cylinder": False}
    kernel.requests["/dev/zero"].happen(0, Kind.RISING_EDGE, 5_000_123)
    assert seen.get(timeout=10) == ("cylinder", True, 5_000_123)
    kernel.requests["/dev/null"].happen(2, Kind.FALLING_EDGE, 6_000_000)
    assert seen.get(timeout=10) == ("bottom", False, 6_000_000)
    lines.close()


@pytest.mark.parametrize(("name", "count"), [("GPIO99", "no"), ("TWIN", "2")])
def test_a_name_that_is_missing_or_ambiguous(kernel: Kernel, name: str, count: str) -> None:
    with pytest.raises(LineNotFoundError, match=rf"{name} \(bottom\) stands on {count} GPIO chip"):
        inputs(bottom=name).start(ignore)


def test_lines_that_somebody_holds(kernel: Kernel) -> None:
    kernel.busy = True
    with pytest.raises(WireError, match="busy"):
        inputs(bottom="GPIO16").start(ignore)


def test_the_second_chip_refusing_gives_back_the_first(kernel: Kernel) -> None:
    lines = inputs(bottom="GPIO16", cylinder="GPIO26")
    first = kernel.request_lines

    def refuse_the_second(path: str, **options: Any) -> Request:
        kernel.busy = bool(kernel.requests)
        return first(path, **options)

    kernel.request_lines = refuse_the_second  # type: ignore[method-assign]
    with pytest.raises(WireError):
        lines.start(ignore)
    lines.close()


def test_debians_old_module_is_refused(kernel: Kernel) -> None:
    kernel.api_version = "1.6"
    with pytest.raises(WireError, match="old API"):
        inputs(bottom="GPIO16").start(ignore)
