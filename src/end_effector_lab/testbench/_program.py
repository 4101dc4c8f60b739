"""The testbench program: runs from a command line to a signal, reads commands, prints messages and writes files."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, nullcontext, suppress
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from types import FrameType
from typing import Any

from end_effector_hal.cli import json_text
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, UsageError, os_errors
from end_effector_hal.signals import Value
from end_effector_hal.wires import PipedLines
from end_effector_hal.wires.lines import Edge

from ._faults import FaultServer
from ._ports import Port
from ._sensor_board import BoardSensors
from ._testbench import Testbench, Watcher
from ._units import Models, played_units
from .inputs import LineInputs

_ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


def run_testbench(
    description: Description,
    inputs: LineInputs,
    ports: Mapping[str, Port],
    sensors: BoardSensors | None = None,
    *,
    models: Models,
    scenario: str,
    seed: int,
    verbose: bool,
    as_json: bool,
    events: Path | None,
    for_pages: bool = False,
) -> None:
    """Run a `Testbench` in the main thread until SIGTERM, SIGINT, SIGHUP or the command ``quit``.

    It prints ``ready: …`` when it reads lines and sends frames, and every edge if ``verbose``; it reads commands from
    standard input (`Commands`), and writes the file of `Events`; with ``for_pages`` it has a `FaultServer`.

    Raises:
        UsageError: an argument cannot be used.
        WireError: lines or port cannot be used, or have gone.
    """
    voice = Voice(as_json=as_json)
    with ExitStack() as stack:
        written = stack.enter_context(closing(Events(events))) if events else None
        mail = Mail(voice if verbose else None, written)
        stack.enter_context(_signals(mail.end))

        def chosen(text: str) -> None:
            mail.post(partial(voice.say, f"scenario: {text}", scenario=text))

        testbench = Testbench(
            description, inputs, ports, sensors, scenario=scenario, seed=seed, watcher=mail, models=models
        )
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
            said += [text for text, _ in played_units(description, models)]
            if units := dict(each for _, each in played_units(description, models)):
                fields["units"] = units
            voice.say(", ".join(said), **fields)
            commands = Commands(voice, bench.choose, mail.end)
            threading.Thread(target=_listen, args=(commands, mail), name="commands", daemon=True).start()
            mail.serve()
        mail.deliver()
        if mail.error:
            raise mail.error


def _listen(commands: Commands, mail: Mail) -> None:
    """Execute every line of standard input as a command."""
    for line in iter(PipedLines(sys.stdin.fileno()).next, None) if sys.stdin is not None else ():
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
    """

    def __init__(self, voice: Voice | None, events: Events | None) -> None:
        self._voice, self._events = voice, events
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


class Voice:
    """Prints one line at a time without buffering; if nobody reads any more, it continues without output.

    Args:
        as_json: print every line as a JSON object.
    """

    def __init__(self, *, as_json: bool = False) -> None:
        self._as_json = as_json

    def say(self, text: str, **fields: object) -> None:
        """Print ``text`` for people, or ``fields`` as JSON for programs."""
        line = json_text(fields) if self._as_json else text
        self._write(line, 1)

    def refuse(self, text: str) -> None:
        """Print a refusal to standard error (with JSON: ``{"refused": …}`` to standard output)."""
        if self._as_json:
            self._write(json_text({"refused": text}), 1)
        else:
            self._write(f"refused: {text}", 2)

    def _write(self, line: str, fd: int) -> None:
        stream = sys.stdout if fd == 1 else sys.stderr
        if stream is None:  # it was closed when the program was started
            return
        try:
            stream.write(line + "\n")
            stream.flush()
        except OSError:  # the buffer keeps its content: let it go where it does no harm
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, fd)
            os.close(silence)


class Commands:
    """Executes commands, one per line: ``scenario TEXT`` and ``quit``.

    Args:
        voice: prints ``scenario: TEXT``, or a refusal.
        choose: called with the text of a scenario.
        end: ends the program.
    """

    def __init__(self, voice: Voice, choose: Callable[[str], None], end: Callable[[], None]) -> None:
        self._voice, self._choose, self._end = voice, choose, end

    def obey(self, line: str) -> None:
        """Execute one command; an empty one does nothing."""
        word, _, rest = line.partition(" ")
        scenario = rest.strip()
        try:
            if word == "scenario" and scenario:
                self._choose(scenario)
                self._voice.say(f"scenario: {scenario}", scenario=scenario)
            elif line == "quit":
                self._end()
            elif line:
                raise UsageError(f"there is no command {line!r}.", todo="There are: scenario TEXT, quit.")
        except UsageError as error:
            self._voice.refuse(str(error))


class Events:
    """JSON lines: ``{"at", "seen", "line", "level"}`` for an edge, ``{"at", "frame", "sent", "values"}`` for a frame.

    ``at`` is monotonic µs: for an edge the time of its writer (``seen``: the time in the testbench), for a frame its
    last byte. The file is flushed after every line: a kill loses at most the last line.

    Args:
        path: path of the file; an existing file is replaced.

    Raises:
        UsageError: the file cannot be written; the methods raise it too.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = path
        with self._errors():
            self._file = Path(path).open("w", encoding="utf-8", buffering=1)  # noqa: SIM115 close() ends it

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        self._entry(at=at, seen=seen, line=name, level=int(level))

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        self._entry(at=at, frame=seq, sent=sent, values=dict(values))

    def close(self) -> None:
        with suppress(OSError):  # said already
            self._file.close()

    def _entry(self, **fields: object) -> None:
        with self._errors():
            self._file.write(json.dumps(fields, separators=(",", ":")) + "\n")

    def _errors(self) -> AbstractContextManager[None]:
        return os_errors("it cannot be written", self._path, todo="Give another path.")


def edges_of(path: str | Path) -> list[Edge]:
    """Return the edges in a file of `Events`."""
    with Path(path).open(encoding="utf-8") as file:
        entries = [json.loads(line) for line in file if line.endswith("\n")]
    return [
        Edge(each["at"], each["line"], "out", bool(each["level"]), 0) for each in entries if "line" in each
    ]
