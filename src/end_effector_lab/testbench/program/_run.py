"""Runs a testbench from its start to a signal."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, nullcontext
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from types import FrameType
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.signals import Value
from end_effector_lab.testbench._board_sensors import BoardSensors
from end_effector_lab.testbench._ports import Port
from end_effector_lab.testbench._testbench import Testbench, Watcher
from end_effector_lab.testbench.inputs import LineInputs

from ._commands import Commands, Voice, lines_of
from ._fault_server import FaultServer
from ._records import Events, Record

_ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


def run_testbench(
    description: Description,
    inputs: LineInputs,
    ports: Mapping[str, Port],
    sensors: BoardSensors | None = None,
    *,
    scenario: str,
    seed: int,
    verbose: bool,
    as_json: bool,
    events: Path | None,
    record: Path | None,
    for_pages: bool = False,
) -> None:
    """Run a `Testbench` in the main thread until SIGTERM, SIGINT, SIGHUP or the command ``quit``.

    It prints ``ready: …`` when it reads lines and sends frames, and every edge if ``verbose``; it reads commands from
    standard input (`Commands`), and writes the files of `Events` and `Record`; with ``for_pages`` it has a
    `FaultServer`.

    Raises:
        UsageError: an argument cannot be used.
        WireError: lines or port cannot be used, or have gone.
    """
    voice = Voice(as_json=as_json)
    with ExitStack() as stack:
        written = stack.enter_context(closing(Events(events))) if events else None
        recorded = stack.enter_context(closing(Record(record))) if record else None
        mail = Mail(voice if verbose else None, written, recorded)
        stack.enter_context(_signals(mail.end))

        def chosen(text: str) -> None:
            mail.post(partial(voice.say, f"scenario: {text}", scenario=text))

        testbench = Testbench(description, inputs, ports, sensors, scenario=scenario, seed=seed, watcher=mail)
        with testbench as bench, FaultServer(description, bench, chosen) if for_pages else nullcontext():
            said = [f"ready: {description.name}, scenario {scenario}, seed {seed}, lines {inputs.text}"]
            fields: dict[str, Any] = {
                "ready": description.name,
                "scenario": scenario,
                "seed": seed,
                "lines": inputs.text,
            }
            for name, port in ports.items():
                codec = bench.codecs[name]
                hertz = 1e6 / codec.period_us
                said.append(f"port {name and f'{name} '}{port.text}, {codec.name} at {hertz:g} Hz")
                told = {"port": port.text, "codec": codec.name, "hertz": hertz}
                fields |= {"ports": {**fields.get("ports", {}), name: told}} if name else told
            if sensors:
                said.append("inputs of the board")
            voice.say(", ".join(said), **fields)
            commands = Commands(voice, bench.choose, mail.end)
            threading.Thread(target=_listen, args=(commands, mail), name="commands", daemon=True).start()
            mail.serve()
        mail.deliver()
        if mail.error:
            raise mail.error


def _listen(commands: Commands, mail: Mail) -> None:
    """Execute every line of standard input as a command."""
    for line in lines_of(sys.stdin.fileno()) if sys.stdin is not None else ():
        mail.post(partial(commands.obey, line))


@contextmanager
def _signals(end: Callable[[], None]) -> Iterator[None]:
    """Handle signals: they end the program, and a background job that reads its terminal is not stopped."""

    def handle(_number: int, _frame: FrameType | None) -> None:
        end()

    before = {number: signal.signal(number, handle) for number in _ENDING}
    before[signal.SIGTTIN] = signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Mail(Watcher):
    """Passes events from threads to the main thread, so that a slow terminal or disk delays no frame.

    Args:
        voice: prints every edge; None: no edge is printed.
        events: file for edges and frames.
        record: file for frames.
    """

    def __init__(self, voice: Voice | None, events: Events | None, record: Record | None) -> None:
        self._voice, self._events, self._record = voice, events, record
        self._queue: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self.ended = False
        self.error: ReportedError | None = None

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        if events := self._events:
            self.post(lambda: events.line(name, level, at, seen))
        if voice := self._voice:
            text = f"{at / 1e6:.6f} {name} {'active' if level else 'inactive'}"
            self.post(lambda: voice.say(text, at=at, line=name, level=level))

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        if events := self._events:
            self.post(lambda: events.frame(at, seq, values, sent))
        if record := self._record:
            self.post(lambda: record.frame(at, values))

    def failed(self, error: ReportedError) -> None:
        self.error = error
        self.end()

    def end(self) -> None:
        """End the program; may be called in a signal handler."""
        self.ended = True
        self.post(lambda: None)

    def post(self, task: Callable[[], None]) -> None:
        """Run a task in the main thread."""
        self._queue.put(task)

    def serve(self) -> None:
        """Run posted tasks in order until the end."""
        while not self.ended:
            self._queue.get()()

    def deliver(self) -> None:
        """Run the posted tasks that are still pending."""
        while not self._queue.empty():
            self._queue.get()()
