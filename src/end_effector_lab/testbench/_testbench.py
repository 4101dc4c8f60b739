"""The bench in real time: threads that read the lines, send frames or answer requests, and output board inputs."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping

from end_effector_hal.codecs import Codec, codec_of, is_polled
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.signals import Value

from ._bench import Bench
from ._ports import Port
from ._scenario import parse_scenario
from ._sensor_board import BoardSensors, SensorBoard, Sent
from ._units import Models, chosen_models
from .inputs import Clock, LineInputs, VirtualInputs, clock_of

RECEIVE_S = 0.1


def by_link(port: Port | Mapping[str, Port] | None, description: Description) -> Mapping[str, Port]:
    """Return ports by the names of their links; a single port belongs to the first link."""
    if port is None or isinstance(port, Mapping):
        return port or {}
    return {next(iter(description.links), ""): port}


class Watcher:
    """Observer of a testbench; its methods are called in the thread of the event and must be quick."""

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        """Handle a change of a line at ``at`` (µs, from the writer) that the testbench read at ``seen``."""

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        """Handle a frame with these values; ``at``: time of its last byte, µs; not ``sent``: the link is silent."""

    def failed(self, error: ReportedError) -> None:
        """Handle the error that ended a thread of the testbench."""


class Testbench:
    """Reads lines and sends frames until it is closed.

    Args:
        description: description of the tool; its link names the codec.
        inputs: the lines that the testbench reads.
        port: port for the frames; for several links by their names; None: the tool has no link.
        sensors: the simulated inputs of the board, if it has any.
        scenario: the faults.
        seed: seed of random events.
        watcher: observer that is called for every event.
        clock: clock of the machine at the other end; default: the result of `clock_of`.
        models: units that have a model; the others are played from the description; default: those of `chosen_models`.

    Raises:
        UsageError: scenario or codec cannot be used.
    """

    __test__ = False  # no test class, whatever pytest thinks of its name

    def __init__(
        self,
        description: Description,
        inputs: LineInputs,
        port: Port | Mapping[str, Port] | None,
        sensors: BoardSensors | None = None,
        *,
        scenario: str = "nominal",
        seed: int = 0,
        watcher: Watcher | None = None,
        clock: Clock | None = None,
        models: Models | None = None,
    ) -> None:
        self._description, self._inputs, self._sensors = description, inputs, sensors
        self._ports = by_link(port, description)
        self._clock = clock or clock_of(inputs)
        self.models = chosen_models(None, description) if models is None else models
        """Units that have a model, by link."""
        self._scenario, self._seed = parse_scenario(scenario, description), seed
        self._watcher = watcher or Watcher()
        self.codecs = {name: codec_of(description, name) for name in self._ports}
        """Codecs by the names of their links."""
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []

    def start(self) -> None:
        """Start; raises WireError if lines or ports cannot be used."""
        try:
            for port in self._ports.values():
                port.open()
            with self._lock:  # an edge waits until there is a bench
                levels = self._inputs.start(self._edge)
                self._start = self._clock.now_us()
                self._bench = Bench(
                    self._description, self._scenario, self._seed, start=self._start, levels=levels
                )
            if self._sensors:
                self._sensors.start()
                self._sensors.play(self._bench.sample(self._start), silent=False)
        except BaseException:
            self._inputs.close()
            for port in self._ports.values():
                port.close()
            raise
        for name, port in self._ports.items():
            codec = self.codecs[name]
            board = SensorBoard(self._description, self._bench, self._start, name, self._obey, self.models)
            board.begin(levels, self._start)
            if is_polled(codec):
                self._begin("frames", self._answer, board, port)
            else:
                self._begin("frames", self._send, board, port, codec)
        if self._sensors:
            self._begin("inputs", self._play, self._sensors)

    @property
    def scenario(self) -> str:
        """Text of the present scenario."""
        return self._scenario.text

    def check(self, scenario: str) -> None:
        """Raise UsageError if a scenario cannot be used."""
        parse_scenario(scenario, self._description)

    def choose(self, scenario: str) -> None:
        """Switch to another scenario; raises UsageError if it cannot be used, and then keeps the old one."""
        parsed = parse_scenario(scenario, self._description)
        with self._lock:
            self._bench.choose(parsed, self._clock.now_us())
            self._scenario = parsed

    def close(self) -> None:
        """Stop; after that nothing is sent, and no watcher is called."""
        self._stop.set()
        self._inputs.close()
        for thread in self._threads:
            thread.join()
        if self._sensors:
            self._sensors.close()
        for port in self._ports.values():
            port.close()

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

    def _obey(self, name: str, level: bool) -> None:
        """Apply an output that was commanded over the link; called with the lock held. A virtual chip shows it to all
        readers.
        """
        if isinstance(self._inputs, VirtualInputs):
            self._inputs.show(name, level)
        else:
            self._bench.line(name, level, self._clock.now_us())

    def _begin(self, name: str, work: Callable[..., None], *given: object) -> None:
        """Start a thread; an error that ends it is reported to the watcher."""

        def run() -> None:
            try:
                work(*given)
            except ReportedError as error:
                self._watcher.failed(error)

        thread = threading.Thread(target=run, name=name, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _ticks(self, period_us: int) -> Iterator[int]:
        """Yield deadlines at multiples of the period from the start, so that delays do not add up."""
        due = self._start
        while not self._clock.wait(self._stop, due):
            # What the machine slept through is left out, and not counted: the wire lost nothing.
            due += max(0, (self._clock.now_us() - due) // period_us) * period_us
            yield due
            due += period_us

    def _send(self, board: SensorBoard, port: Port, codec: Codec) -> None:
        for due in self._ticks(codec.period_us):
            with self._lock:
                sent = board.frame(due)
            self._put(sent, port)

    def _answer(self, board: SensorBoard, port: Port) -> None:
        while not self._stop.is_set():
            request = port.receive(RECEIVE_S)
            with self._lock:
                now = self._clock.now_us()
                board.advance(now)
                sent, refuses = board.answer(request, now) if request else None, board.closed(now)
            port.refuse(refuses=refuses)
            if sent is not None and not self._stop.wait(sent.late_us / 1e6):
                self._put(sent, port)

    def _put(self, sent: Sent, port: Port) -> None:
        at = self._clock.now_us()  # before the write: a reader may have it before the write returns
        if sent.data and sent.reset:
            port.cut(sent.data)
        elif sent.data:
            at += port.send(sent.data)
        self._watcher.frame(at, sent.seq, sent.values, bool(sent.data))

    def _play(self, sensors: BoardSensors) -> None:
        for seq, due in enumerate(self._ticks(sensors.period_us)):
            with self._lock:
                values, silent = self._bench.sample(due), self._bench.silent(due)
            sensors.play(values, silent=silent)
            if not self._ports:
                self._watcher.frame(due, seq, values, not silent)
