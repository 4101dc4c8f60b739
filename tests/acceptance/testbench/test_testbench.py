"""The two threads, on a clock that the test moves."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description
from end_effector_hal.errors import LinkError, ReportedError, UsageError
from end_effector_hal.signals import Frame, Value
from end_effector_hal.wires import now_us
from end_effector_lab.testbench import Testbench
from end_effector_lab.testbench._testbench import Watcher
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.wall

START = 1_000_000_000


class Clock:
    """Each wait is late, and there are not more of them than frames."""

    def __init__(self, frames: int, late_us: Callable[[int], int]) -> None:
        self.now, self._left, self._late = START, frames, late_us
        self.waits = 0

    def now_us(self) -> int:
        return self.now

    def wait(self, stop: threading.Event, until: int) -> bool:
        self.now = max(self.now, until) + self._late(self.waits)
        self.waits += 1
        return self.waits > self._left


class Inputs:
    text = "test"

    def __init__(self, **levels: bool) -> None:
        self.levels = levels
        self.closed = False

    def start(self, on_edge: Callable[[str, bool, int], None]) -> dict[str, bool]:
        self.on_edge = on_edge
        return self.levels

    def close(self) -> None:
        self.closed = True


class Port:
    text = "test"

    def __init__(self, *, lasts: int = 10**9, takes_us: int = 0) -> None:
        self.sent: list[bytes] = []
        self.closed = False
        self._lasts, self._takes_us = lasts, takes_us

    def open(self) -> None:
        pass

    def send(self, data: bytes) -> int:
        if len(self.sent) >= self._lasts:
            raise LinkError("the port has gone.")
        self.sent.append(data)
        return self._takes_us

    def close(self) -> None:
        self.closed = True

    def frames(self) -> list[Frame]:
        return get_codec("ees1-ascii").decoder().feed(b"".join(self.sent), 0)


class Log(Watcher):
    def __init__(self) -> None:
        self.lines: list[tuple[str, bool, int]] = []
        self.frames: list[tuple[int, int, bool]] = []
        self.error: ReportedError | None = None

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        self.lines.append((name, level, at))

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        self.frames.append((at, seq, sent))

    def failed(self, error: ReportedError) -> None:
        self.error = error


def run(
    description: Description,
    *,
    frames: int = 50,
    late_us: Callable[[int], int] = lambda wait: 0,
    inputs: Inputs | None = None,
    port: Port | None = None,
    **options: Any,
) -> tuple[Port, Log]:
    clock, port, log = Clock(frames, late_us), port or Port(), Log()
    bench = Testbench(description, inputs or Inputs(), port, watcher=log, clock=clock, **options)
    bench.start()
    for thread in bench._threads:
        thread.join(30)
    bench.close()
    assert port.closed
    return port, log


def test_lateness_does_not_add_up(verdin: Description) -> None:
    port, log = run(verdin, late_us=lambda wait: 3_000)
    assert [at - START for at, _, _ in log.frames] == [number * 20_000 + 3_000 for number in range(50)]
    assert [(frame.seq, frame.device_ms) for frame in port.frames()] == [(n, 20 * n) for n in range(50)]


def test_what_was_slept_through_is_left_out(verdin: Description) -> None:
    port, log = run(verdin, frames=5, late_us=lambda wait: 70_000 if wait == 2 else 0)
    assert [at - START for at, _, _ in log.frames] == [0, 20_000, 110_000, 120_000, 140_000]
    assert [(frame.seq, frame.device_ms) for frame in port.frames()] == [
        (0, 0),
        (1, 20),
        (2, 100),
        (3, 120),
        (4, 140),
    ]


def test_the_last_byte_is_later_on_a_slow_wire(verdin: Description) -> None:
    _, log = run(verdin, frames=2, port=Port(takes_us=5_000))
    assert [at - START for at, _, _ in log.frames] == [5_000, 25_000]


def test_silence_is_on_the_wire_only(verdin: Description) -> None:
    port, log = run(verdin, scenario="silent-after:0.2")
    assert [frame.seq for frame in port.frames()] == list(range(10))
    assert [sent for _, _, sent in log.frames] == [True] * 10 + [False] * 40


def test_noise_is_on_the_wire_only(verdin: Description) -> None:
    port, log = run(verdin, scenario="noise:0.01", frames=200)
    assert len(port.sent) == len(log.frames) == 200
    assert 20 < len(port.frames()) < 180


def test_what_is_held_at_the_start_is_held(verdin: Description) -> None:
    port, _ = run(verdin, inputs=Inputs(SODIMM_208=True), frames=1)
    (frame,) = port.frames()
    assert frame.values["bottom"] == pytest.approx(-85_000, abs=500)


def test_a_port_that_goes_ends_the_frames_and_is_told(verdin: Description) -> None:
    _, log = run(verdin, port=Port(lasts=3))
    assert len(log.frames) == 3
    assert isinstance(log.error, LinkError)


def test_the_prototypes_format(verdin: Description) -> None:
    link = verdin.link.model_copy(update={"codec": "legacy-nibble", "baudrate": 9600})
    old = verdin.model_copy(update={"link": link})
    port, log = run(old, frames=3, inputs=Inputs(SODIMM_208=True, SODIMM_206=True))
    assert port.sent == [b"\x0c"] * 3
    assert [at - START for at, _, _ in log.frames] == [0, 1_000_000, 2_000_000]


def test_edges_reach_the_bench_and_a_scenario_can_be_chosen(verdin: Description) -> None:
    enough, confirmed = threading.Event(), threading.Event()

    class Waits(Watcher):
        def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
            if values["supply"] < 400_000:  # type: ignore[operator]
                enough.set()
            if values["bottom"] < -55_000:  # type: ignore[operator]
                confirmed.set()

    inputs, port = Inputs(), Port()
    with Testbench(verdin, inputs, port, watcher=Waits()) as bench:
        inputs.on_edge("SODIMM_208", True, now_us())
        assert confirmed.wait(PATIENCE_S)
        with pytest.raises(UsageError):
            bench.choose("nonsense")
        bench.choose("supply:300")
        assert enough.wait(PATIENCE_S)
    assert inputs.closed
    assert port.closed


def test_nothing_is_left_open_when_the_lines_cannot_be_used(verdin: Description) -> None:
    class Broken(Inputs):
        def start(self, on_edge: Callable[[str, bool, int], None]) -> dict[str, bool]:
            raise LinkError("no lines.")

    inputs, port = Broken(), Port()
    with pytest.raises(LinkError), Testbench(verdin, inputs, port):
        pass
    assert inputs.closed
    assert port.closed


def test_an_edge_during_the_start_is_not_lost(verdin: Description) -> None:
    class Hasty(Inputs):
        def start(self, on_edge: Callable[[str, bool, int], None]) -> dict[str, bool]:
            self.edge = threading.Thread(target=on_edge, args=("SODIMM_206", True, 0))
            self.edge.start()
            self.edge.join(0.1)  # in vain: there is no bench yet
            return {}

    inputs, log = Hasty(), Log()
    with Testbench(verdin, inputs, Port(), watcher=log):
        inputs.edge.join(20)
    assert log.lines == [("SODIMM_206", True, 0)]
