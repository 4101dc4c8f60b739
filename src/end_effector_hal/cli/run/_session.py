"""A session of ``eehal run``: executes commands from a script or a prompt and reports how they end."""

from __future__ import annotations

import math
import os
import select
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path
from queue import Empty, SimpleQueue

import click

from end_effector_hal.cli._output import LOST
from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Outcome
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.owned import open_owned
from end_effector_hal.runtime import (
    WORDS,
    EndEffector,
    Result,
    RunningGoal,
    ScriptCommand,
    Tool,
    read_command,
)
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import PipedLines

from ._voices import SCENARIO, Changes, Voice

PROMPT = "> "
MOST_REMEMBERED = 1_000
LOOK_S = 0.02
"""Interval at which running commands are checked, s."""
END_S, LAST_LINES_S = 5.0, 0.5
"""Longest waits at the end, s: for the ends of commands, and for the reader of the output."""
AT_ONCE = (Command.CANCEL, Command.QUIT)
HELP = """\
lock, unlock     the tool changer; arm: allows an unlock where no sensor shows the tool's stand
grip, drop       the actuators, in their order and in the reverse order
cancel           a running grip
resume           after a loss: GRIPPED again, if all evidence is confirmed again
stop             nothing is activated until a reset, a running grip is cancelled, what is held stays; no safety function
reset            clears latched faults and alarms that are over
status           the state of everything, with the times of the last grip
set NAME on|off  a plain output of the tool (`outputs`)
wait SECONDS     then the next command"""
OF_PROMPT = """
reload           the description as it is in the file now: checked first, at rest only, else the old one stays
scenario NAME    with --simulate: what goes wrong from now on, such as leak:ACTUATOR; nominal: nothing
quit             leaves; what is held stays held
Arrow keys and Ctrl-R search earlier commands, Tab completes. Ctrl-C ends as the description declares (`endings`)."""


class CommandThread:
    """Runs the steps of commands concurrently in one thread, which is made at the start and survives exceptions of a
    step.
    """

    def __init__(self) -> None:
        self._given: SimpleQueue[Iterator[None]] = SimpleQueue()
        self.give = self._given.put
        thread = threading.Thread(target=self._run, name="commands", daemon=True)
        thread.start()
        self.alive = thread.is_alive

    def _run(self) -> None:
        running: list[Iterator[None]] = []
        while True:
            try:
                with suppress(Empty):
                    running.append(self._given.get(timeout=LOOK_S if running else None))
                running = [steps for steps in running if next(steps, self) is not self]
            except Exception:  # noqa: BLE001 without memory, nearly anything
                time.sleep(LOOK_S)


class RunSession:
    """Gives commands to a tool and reports how they ended.

    Args:
        tool: the tool that receives the commands.
        voice: prints the reports.
        changes: reports the states before a result.
        choose: selects another scenario at the testbench, or raises UsageError.
        reload: returns whether the changed description can be used.
        commands: the thread that gives the commands.
        ending: called when the program ends.

    Attributes:
        reloads: whether the session ended in order to use another description; the remaining commands are executed
            afterwards.
    """

    def __init__(
        self,
        tool: Tool,
        voice: Voice,
        changes: Changes,
        choose: Callable[[str], None],
        reload: Callable[[], Answer],
        commands: CommandThread,
        ending: Callable[[], None],
    ) -> None:
        self._choose, self._reload = choose, reload
        self._commands, self._ending = commands, ending
        self.reloads = False
        self._tool, self._voice, self._changes = tool, voice, changes
        self._running: list[threading.Event] = []
        self._succeeded = True

    def play(self, orders: Iterable[ScriptCommand], *, interactive: bool = False) -> bool:
        """Execute the commands; return whether all of them succeeded.

        Args:
            orders: the commands, executed one after the other.
            interactive: whether a person types them: the next command is read while one runs, so that a cancel is
                possible.
        """
        try:
            for order in orders:
                if (
                    interactive
                    and order.command not in AT_ONCE
                    and not (order.show or order.output or order.scenario or order.stop)
                ):
                    self._finish()
                if order.command is Command.QUIT:
                    break
                try:
                    self._carry_out(order, wait=not (order.background or interactive))
                except Exception as error:  # noqa: BLE001 no memory, no thread: nothing ends while a part is held
                    self._failed(order.command, error)
                if self.reloads:
                    break
            self._finish()
        finally:  # Ctrl-C and SIGTERM as well: each command gets its end, in words
            if not self.reloads:
                self._ending()
            status = self._tool.status
            said = self._tool.ending()
            # else the end of the command says so
            if said and (status.command is Command.NONE or all(ended.is_set() for ended in self._running)):
                self._voice.ending(said)
            self._tool.close()
            self._finish(time.monotonic() + END_S)
        return self._succeeded

    def _carry_out(self, order: ScriptCommand, *, wait: bool) -> None:
        if order.show == "help":
            self._voice.help(HELP + (OF_PROMPT if isinstance(self._tool, EndEffector) else ""))
        elif order.show:
            self._voice.status(self._tool.description, self._tool.status)
        elif order.output:
            self._answered("SET", self._switched(order))
        elif order.scenario:
            self._answered(SCENARIO, self._chosen(order.scenario))
        elif order.resume:
            self._answered("RESUME", self._tool.resume())
        elif order.arm:
            self._answered("ARM", self._tool.arm())
        elif order.stop:
            self._answered("STOP", self._tool.stop())
        elif order.reload:
            self._finish()
            answer = self._reload()
            self._answered("RELOAD", answer)
            self.reloads = answer.accepted
        elif order.reset:
            self._answered("RESET", self._tool.reset())
        elif order.command is None:
            time.sleep(order.wait_s)
        else:
            # not in this thread: a signal must not interrupt the program of the tool in the middle of a step
            ended = threading.Event()
            self._running.append(ended)
            self._commands.give(self._run(order.command, order.part, ended))
            if wait:
                self._wait(ended)

    def _switched(self, order: ScriptCommand) -> Answer:
        try:
            return self._tool.set_output(order.output, order.active)
        except UsageError as error:  # there is none of that name: the next command may be right
            return Answer(False, str(error))

    def _chosen(self, scenario: str) -> Answer:
        try:
            self._choose(scenario)
        except UsageError as error:
            return Answer(False, str(error))
        return Answer(True, scenario)

    def _finish(self, until_s: float = math.inf) -> None:
        """Wait for the ends of all commands, at most until ``until_s`` on the monotonic clock."""
        for ended in self._running:
            self._wait(ended, until_s)
        self._running.clear()

    def _wait(self, ended: threading.Event, until_s: float = math.inf) -> None:
        while not ended.wait(min(1.0, max(0.0, until_s - time.monotonic()))) and time.monotonic() < until_s:
            if not self._commands.alive():
                why = "The thread of commands has ended: start this program again. `stop` still works."
                self._answered("COMMAND", Answer(False, why, decided=False))
                return

    def _answered(self, name: str, answer: Answer) -> None:
        self._succeeded = self._succeeded and answer.accepted
        self._voice.answer(name, answer)

    def _failed(self, command: Command | None, error: Exception) -> None:
        why = f"It was not carried out to its end: {str(error) or type(error).__name__}. `status` shows the state."
        self._answered(command.name if command is not None else "COMMAND", Answer(False, why, decided=False))

    def _run(self, command: Command, part: str, ended: threading.Event) -> Iterator[None]:
        try:
            if command is Command.CANCEL:
                self._answered(command.name, self._tool.cancel())
                return
            result: Result | RunningGoal = self._tool.begin(command, part)
            while isinstance(result, RunningGoal):
                try:
                    result = result.wait(0.0)
                except TimeoutError:
                    yield
            self._succeeded = self._succeeded and result.succeeded
            if result.outcome is not Outcome.UNREACHABLE:
                self._changes.catch_up(self._tool.status)
            self._voice.result(command, result)
        except Exception as error:  # noqa: BLE001 no memory, perhaps: the next command may succeed
            self._failed(command, error)
        finally:
            ended.set()


class Prompt:
    """Reads commands from standard input; on a terminal with history, completion, and messages above the typed line.

    Args:
        shown: whether a person types; otherwise lines are read without a prompt.
    """

    def __init__(self, *, shown: bool) -> None:
        self.shown = shown
        self._reading, self._until_s = False, math.inf
        self._piped: PipedLines | None = None
        self._typed: Callable[[], str] = str
        self.lost: OSError | None = None
        """Why the output lacks a line, where it goes to a disk; None: it lacks none."""

    def end(self) -> None:
        """End the program's output: from now on no write waits for more than half a second for the reader of the
        output.
        """
        self._until_s = time.monotonic() + LAST_LINES_S

    def write(self, text: str, *, err: bool = False) -> None:
        """Print a line, from one thread at a time; on a terminal it appears above the text being typed. Raises
        OSError.
        """
        end = "\n"
        if self._reading:
            text, end = f"\r\x1b[K{text}\n{PROMPT}{self._typed()}", ""
        stream = sys.stderr if err else sys.stdout
        left = ((text if stream.isatty() else click.unstyle(text)) + end).encode(stream.encoding, "replace")
        number = stream.fileno()
        # without a buffer: the end of the interpreter would wait for what is in it
        while left:
            while not select.select([], [number], [], LAST_LINES_S / 5)[1]:
                if time.monotonic() > self._until_s:
                    raise TimeoutError("no process reads the output")
            try:
                left = left[os.write(number, left[: select.PIPE_BUF]) :]
            except OSError as error:
                self.lost = error if error.errno in LOST else self.lost
                raise

    def commands(self, refuse: Callable[[ReportedError], None]) -> Iterator[ScriptCommand]:
        """Yield each typed command until the end of the input."""
        if self.shown:
            self._with_history()
            if isinstance(sys.stdin, TextIOWrapper):
                sys.stdin.reconfigure(errors="replace")  # what is no text is an unknown command
        read = False
        while True:
            try:
                if (text := self._line()) is None:
                    break
                read = True
                if text:
                    yield read_command(text)
            except UsageError as error:
                refuse(error)
            except MemoryError:
                refuse(UsageError("A command could not be read: there is not enough memory."))
                time.sleep(1.0)
        if not read and not self.shown:
            refuse(UsageError("Standard input ended before the first command. See also --script."))

    def _line(self) -> str | None:
        try:
            self._reading = self.shown
            if self.shown:
                return input(PROMPT).strip()
            self._piped = self._piped or PipedLines(sys.stdin.fileno())
            return self._piped.next()
        except (EOFError, OSError):  # the terminal has gone
            return None
        finally:
            self._reading = False

    def _with_history(self) -> None:
        try:
            import readline
        except ImportError:  # a Python without it: typed all the same
            return
        import atexit

        file = history_file()
        with suppress(OSError):
            file.parent.mkdir(parents=True, exist_ok=True)
            readline.read_history_file(file)
        readline.set_history_length(MOST_REMEMBERED)
        readline.set_completer(_complete)
        readline.parse_and_bind("tab: complete")
        self._typed = readline.get_line_buffer

        def keep() -> None:
            with suppress(OSError):
                os.close(open_owned(file, os.O_WRONLY | os.O_CREAT))
                readline.write_history_file(file)

        atexit.register(keep)


def history_file() -> Path:
    """Return the path of the command history."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "end-effector-hal" / "history"


def _complete(text: str, number: int) -> str | None:
    found = [word for word in WORDS if word.startswith(text)]
    return found[number] if number < len(found) else None
