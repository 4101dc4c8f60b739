"""``eehal run``: one tool in this terminal, without ROS."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import NotReadyError, UsageError

from ._options import PathName, end_in_order

if TYPE_CHECKING:
    from end_effector_hal.control import Answer, Status, StepReport
    from end_effector_hal.description import Description
    from end_effector_hal.errors import ReportedError
    from end_effector_hal.recording import Recording
    from end_effector_hal.runtime import EndEffector, ScriptCommand
    from end_effector_hal.vocabulary import Command


class Words:
    """States and results on stdout, the rest on stderr."""

    def state(self, ee: str, actuators: dict[str, str]) -> None:
        """The labels of the figures."""
        from end_effector_hal.vocabulary import display_name

        click.echo(f"{ee}: {', '.join(f'{display_name(name)} {each}' for name, each in actuators.items())}")

    def alarm(self, text: str, *, over: bool) -> None:
        """One line each."""
        click.echo(f"{'no longer' if over else 'alarm'}: {text}", err=True)

    def result(self, name: str, succeeded: bool, reason: str, steps: Sequence[StepReport] = ()) -> None:
        """With the reason in words."""
        click.echo(f"{name}: {'succeeded' if succeeded else 'failed'}{f'. {reason}' if reason else ''}")

    def error(self, error: ReportedError) -> None:
        """The sentence."""
        click.echo(str(error), err=True)


class JsonLines:
    """An object a line on stdout; ``event`` says what it is."""

    def state(self, ee: str, actuators: dict[str, str]) -> None:
        """The same labels."""
        self._tell(event="state", end_effector=ee, actuators=actuators)

    def alarm(self, text: str, *, over: bool) -> None:
        """``over``: it is gone."""
        self._tell(event="alarm", text=text, over=over)

    def result(self, name: str, succeeded: bool, reason: str, steps: Sequence[StepReport] = ()) -> None:
        """With the attempts and the time of each step."""
        told = [asdict(step) for step in steps]
        self._tell(event="result", command=name, succeeded=succeeded, reason=reason, steps=told)

    def error(self, error: ReportedError) -> None:
        """Its faults as everywhere."""
        self._tell(event="error", faults=[fault.as_json() for fault in error.diagnostics])

    def _tell(self, **content: object) -> None:
        click.echo(json.dumps(content, ensure_ascii=False))


Voice = Words | JsonLines


class Changes:
    """Tells each change of state and each new alarm once."""

    def __init__(self, description: Description, voice: Voice) -> None:
        self._description, self._voice = description, voice
        self._last: tuple[str, dict[str, str]] | None = None
        self._alarms: tuple[str, ...] = ()

    def status(self, status: Status) -> None:
        """One more."""
        from end_effector_hal.kinds import kind_of

        states = zip(self._description.ordered, status.actuators, strict=True)
        actuators = {name: kind_of(part).states(state).label for (name, part), state in states}
        if (now := (status.ee.label, actuators)) != self._last:
            self._last = now
            self._voice.state(*now)
        for alarm in status.alarms:
            if alarm not in self._alarms:
                self._voice.alarm(alarm, over=False)
        for alarm in self._alarms:
            if alarm not in status.alarms:
                self._voice.alarm(alarm, over=True)
        self._alarms = status.alarms


READY_S = 10.0
RECORDING = "that records"


@click.command("run")
@click.argument("description", type=PathName())
@click.option("--script", help="Commands instead of the prompt, such as 'lock; grip; wait 2; drop'.")
@click.option(
    "--simulate",
    is_flag=True,
    help="Without hardware: virtual lines, with a testbench and a line arbiter of its own that end with it.",
)
@click.option("--record", type=PathName(), help="Folder for the recording of the run.")
@click.option(
    "--segment-mb",
    default=64.0,
    show_default=True,
    help="A file of the recording is cut into such segments, MB.",
)
@click.option(
    "--keep-mb",
    default=1000.0,
    show_default=True,
    help="The recording keeps so much, MB; the oldest segments are removed.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines: states, alarms, results.")
def command(
    description: Path,
    script: str | None,
    simulate: bool,
    record: Path | None,
    segment_mb: float,
    keep_mb: float,
    as_json: bool,
) -> None:
    """Give commands to one tool: lock, unlock, grip, drop, cancel, arm, reset, wait SECONDS, quit.

    The line arbiter of the tool (`eehal arbiter DESCRIPTION`) must run; with --simulate nothing must. A command
    followed by `&` goes on in the background, so that it can be cancelled. Quitting releases nothing that is held;
    Ctrl-C and SIGTERM do what the description declares (`endings: sigterm`).
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.recording import Recording, RecordingLimits
    from end_effector_hal.runtime import EndEffector, read_script
    from end_effector_hal.wires import be_steady

    from ._run import Changes, JsonLines, Words
    from ._simulation import simulated

    limits = RecordingLimits.of_megabytes(segment_mb, keep_mb)
    orders = read_script(script) if script is not None else None
    loaded, voice = load_tool(description), JsonLines() if as_json else Words()
    if record is not None:
        _try_to_write(record)
    end_in_order()
    with ExitStack() as stack:
        if simulate:
            loaded = stack.enter_context(simulated(loaded))
            click.echo("Simulated: virtual lines and a testbench; nothing real moves.", err=True)
            click.echo(f"Live in a browser: eehal page {loaded.source}", err=True)
        tool = stack.enter_context(EndEffector(loaded, traces=record, limits=limits))
        if record is not None:
            _record(tool, stack.enter_context(Recording(record, loaded, limits=limits)))
            stack.callback(tool.close)  # its last states are recorded
        tool.subscribe(Changes(loaded, voice).status)
        tool.start()
        try:
            tool.wait_ready(READY_S)
        except NotReadyError as error:
            voice.error(error)  # what is held can be dropped all the same
        be_steady()
        prompt = "> " if sys.stdin.isatty() and not as_json else ""
        session = _Session(tool, voice)
        succeeded = session.play(iter(orders) if orders is not None else _prompt(prompt, voice))
    sys.exit(0 if succeeded else 1)


def _try_to_write(folder: Path) -> None:
    """Told once and before anything begins: each program would tell it of its trace."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError as error:
        raise UsageError(
            f"The recording cannot be written: {error.strerror}.",
            where=str(folder),
            todo="Name another folder.",
        ) from None


def _record(tool: EndEffector, recording: Recording) -> None:
    def state(status: Status) -> None:
        recording.state(status.at, status.ee, status.command, status.actuators)
        recording.alarms(status.at, status.alarms)

    tool.subscribe(state, name=RECORDING)
    tool.subscribe_frames(lambda frame: recording.values(frame.at, frame.values), name=RECORDING)


class _Session:
    """Gives commands to a tool and says how they ended."""

    def __init__(self, tool: EndEffector, voice: Voice) -> None:
        self._tool, self._voice = tool, voice
        self._running: list[threading.Thread] = []
        self._succeeded = True

    def play(self, orders: Iterator[ScriptCommand]) -> bool:
        """Whether every command succeeded."""
        from end_effector_hal.vocabulary import Command

        for order in orders:
            if order.command is Command.QUIT:
                break
            if order.arm:
                self._answered("ARM", self._tool.arm())
                continue
            if order.reset:
                self._answered("RESET", self._tool.reset())
                continue
            if order.command is None:
                time.sleep(order.wait_s)
                continue
            # not in this thread: a signal must not interrupt the program of the tool in the middle of a step
            thread = threading.Thread(target=self._run, args=(order.command,), daemon=True)
            thread.start()
            self._running.append(thread)
            if not order.background:
                thread.join()
        for thread in self._running:
            thread.join()
        return self._succeeded

    def _answered(self, name: str, answer: Answer) -> None:
        self._succeeded = self._succeeded and answer.accepted
        self._voice.result(name, answer.accepted, answer.reason)

    def _run(self, command: Command) -> None:
        from end_effector_hal.vocabulary import Command

        if command is Command.CANCEL:
            self._answered(command.name, self._tool.cancel())
            return
        result = self._tool.begin(command).wait()
        self._succeeded = self._succeeded and result.succeeded
        self._voice.result(command.name, result.succeeded, result.reason, result.steps)


def _prompt(prompt: str, voice: Voice) -> Iterator[ScriptCommand]:
    from end_effector_hal.runtime import read_command

    while True:
        try:
            text = input(prompt).strip()
        except EOFError:
            return
        if not text:
            continue
        try:
            yield read_command(text)
        except UsageError as error:
            voice.error(error)
