"""The bench in real time: a thread that sees the lines, a thread that sends frames or answers requests."""

from __future__ import annotations

import threading
from collections.abc import Mapping

from end_effector_hal.codecs import Codec, codec_of, is_polled
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.signals import Value

from ._bench import Bench
from ._ports import Port
from ._scenario import parse_scenario
from ._sensor_board import SensorBoard, Sent
from .inputs import Clock, LineInputs, clock_of

RECEIVE_S = 0.1


class Watcher:
    """What a testbench tells of itself; each is called in the thread where it happens and must be quick."""

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        """A line changed at ``at`` (µs, by the one who wrote it) and was seen at ``seen``."""

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        """A frame with these values; ``at``: µs of its last byte; not ``sent``: the link is silent."""

    def failed(self, error: ReportedError) -> None:
        """The frames have ended."""


class Testbench:
    """Lines in, frames out, until it is closed.

    Args:
        description: of the tool; its link names the codec.
        inputs: where the lines are seen.
        port: where the frames go.
        scenario: what goes wrong.
        seed: of the chance in it.
        watcher: is told what happens.
        clock: of the machine at the other end; default: what `clock_of` says.

    Raises:
        UsageError: scenario or codec cannot be used.
    """

    __test__ = False  # no test class, whatever pytest thinks of its name

    def __init__(
        self,
        description: Description,
        inputs: LineInputs,
        port: Port,
        *,
        scenario: str = "nominal",
        seed: int = 0,
        watcher: Watcher | None = None,
        clock: Clock | None = None,
    ) -> None:
        self._description, self._inputs, self._port = description, inputs, port
        self._clock = clock or clock_of(inputs)
        self._scenario, self._seed = parse_scenario(scenario, description), seed
        self._watcher = watcher or Watcher()
        self.codec: Codec = codec_of(description)
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._frames, name="frames", daemon=True)

    def start(self) -> None:
        """Begin; raises WireError if lines or port cannot be used."""
        self._port.open()
        try:
            with self._lock:  # an edge waits until there is a bench
                levels = self._inputs.start(self._edge)
                self._start = self._clock.now_us()
                self._bench = Bench(
                    self._description, self._scenario, self._seed, start=self._start, levels=levels
                )
                self._board = SensorBoard(self.codec, self._bench, self._description, self._start)
        except BaseException:
            self._inputs.close()
            self._port.close()
            raise
        self._thread.start()

    def choose(self, scenario: str) -> None:
        """Another scenario from now on; raises UsageError if it cannot be used, and goes on as before."""
        parsed = parse_scenario(scenario, self._description)
        with self._lock:
            self._bench.choose(parsed, self._clock.now_us())

    def close(self) -> None:
        """End; nothing is sent or told after it."""
        self._stop.set()
        self._inputs.close()
        self._thread.join()
        self._port.close()

    def __enter__(self) -> Testbench:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _edge(self, name: str, level: bool, at: int) -> None:
        seen = self._clock.now_us()
        with self._lock:
            self._bench.line(name, level, at)
        self._watcher.line(name, level, at, seen)

    def _frames(self) -> None:
        try:
            if is_polled(self.codec):
                self._answer()
            else:
                self._send()
        except ReportedError as error:
            self._watcher.failed(error)

    def _send(self) -> None:
        """Each frame has its own deadline from the start, so that no lateness adds up."""
        period_us, due = self.codec.period_us, self._start
        while not self._clock.wait(self._stop, due):
            # Frames that the machine slept through are left out, and not counted: the wire lost nothing.
            due += max(0, (self._clock.now_us() - due) // period_us) * period_us
            with self._lock:
                sent = self._board.frame(due)
            self._put(sent)
            due += period_us

    def _answer(self) -> None:
        while not self._stop.is_set():
            request = self._port.receive(RECEIVE_S)
            with self._lock:
                sent = self._board.answer(request, self._clock.now_us()) if request else None
            if sent is not None:
                self._put(sent)

    def _put(self, sent: Sent) -> None:
        at = self._clock.now_us()  # before the write: a reader may have it before the write returns
        if sent.data:
            at += self._port.send(sent.data)
        self._watcher.frame(at, sent.seq, sent.values, bool(sent.data))
