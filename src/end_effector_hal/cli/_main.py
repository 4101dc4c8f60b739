"""The group of all commands. It prints errors as sentences and sets the exit code."""

from __future__ import annotations

import atexit
import errno
import gc
import importlib
import os
import sys
from difflib import get_close_matches
from io import FileIO, TextIOWrapper
from typing import Any, TextIO

import click

from end_effector_hal._extras import lab_installed, lab_needed, missing_extra
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.plugins import Plugins

from ._output import LOST, print_line

GROUP = "end_effector_hal.commands"
"""Entry-point group of further commands; a command of this package has precedence over one of the same name."""
_COMMANDS: dict[str, dict[str, str]] = {
    "To run a tool and look at it (operators)": {
        "run": "one tool in this terminal, without ROS",
        "serve": "run a tool as a service, without ROS and without a prompt",
        "do": "give commands to a tool that runs, from any terminal",
        "status": "the state of a tool that runs",
        "stop": "latch a stop: nothing is activated until a reset; no safety function",
        "reset": "clear what the line arbiter of a tool has latched",
        "reload": "check a changed description, and whether what runs may take it over",
        "page": "a tool in a browser: live, or as it was recorded",
        "history": "grips per day, outcomes, times and margins over time, from the recordings of a tool",
        "record": "record a tool that runs, in a process of its own",
        "arbiter": "own the output lines of a tool and serve them on a socket",
        "doctor": "what this machine lacks to run a tool, and what to do",
    },
    "To describe a tool and connect it (integrators)": {
        "init": "a folder with a description to start from, and its schema",
        "check": "say everything that is wrong with a description",
        "devices": "the devices of the library, for `device: NAME` in a description",
        "schema": "the JSON Schema of a description, for editors",
        "listen": "what arrives on each channel, live; thresholds from a recording",
        "tune": "",
        "testbench": "",
        "export": "a tool for other programs: a xacro",
        "plugin": "codecs, kinds and commands of your own in this environment",
        "completion": "shell completion of commands and values",
    },
    "To prove, try out and judge it (researchers)": {
        "demo": "",
        "matrix": "",
        "campaign": "",
        "verify": "prove what the automata promise, or show a counterexample",
        "model": "show, play, export and check the automata",
        "replay": "the same program on recorded inputs: decisions compared, steps judged by the automata",
        "plot": "",
        "compare": "",
        "report": "",
        "import": "",
    },
}
"""The commands by their users, in the order in which they are needed, with their help. That of `end_effector_lab` is
empty here: only the extra `lab` makes its commands usable, which are left out where it is not installed.
"""
_OWN = {name: said for group in _COMMANDS.values() for name, said in group.items() if said}
_WORKSHOP = [name for group in _COMMANDS.values() for name, said in group.items() if not said]
_OTHERS = "Added by other distributions"
_OTHER_NAMES = {
    "figure": "plot", "draw": "plot", "prove": "verify", "new": "init", "validate": "check", "lint": "check",
    "simulate": "model simulate", "diff": "compare", "watch": "listen",
}  # fmt: skip
"""Names that other programs use for a command, for the hint "Did you mean"."""
_LINUX = ("fcntl", "grp", "inotify_simple", "pwd", "termios", "tty")
"""Linux-only modules; only the commands that use lines, ports or locks import them."""
_JUDGING = (
    "campaign", "check", "compare", "doctor", "import", "matrix", "model", "replay", "report", "verify",
)  # fmt: skip
"""Commands that end by themselves and whose exit code states their result."""
_SERVING = ("arbiter", "page", "testbench")
"""Commands that go on without their output."""
_UNWRITABLE = (*LOST, errno.EIO)
_LIMITS = "Look at its limits: ulimit -a; under systemd TasksMax and MemoryMax."
_PLACES = {
    **{name: f"_arbiter:{name}" for name in ("arbiter", "reload", "reset", "stop")},
    **{name: f"{name}._{name}:command" for name in ("doctor", "init", "listen", "model", "plugin")},
    **{name: f"run._run:{name}" for name in ("run", "serve")},
    **{name: f"run._clients:{name}" for name in ("do", "record", "status")},
    "page": "recorded:command",
    "schema": "_completion:schema",
}
"""Module and function of a command; of all others, the function ``command`` of the module with their name."""


def _checked(command: object) -> click.Command:
    if not isinstance(command, click.Command):
        raise UsageError("the entry point must name a click.Command.")
    return command


_ADDED: Plugins[click.Command] = Plugins(GROUP, "command", {}, _checked, make=False)


class _LazyGroup(click.Group):
    """A group that loads the module of a command only when the command is called, so that ``eehal`` starts quickly."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        hidden = () if lab_installed() else _WORKSHOP
        return sorted({*_OWN, *_ADDED.names}.difference(hidden))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name in _OWN:
            module, _, function = _PLACES.get(cmd_name, f"_{cmd_name}:command").partition(":")
            command: click.Command = getattr(importlib.import_module(f"{__package__}.{module}"), function)
            return command
        return _ADDED.get(cmd_name) if cmd_name in _ADDED.names else None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        names = self.list_commands(ctx)
        others = [name for name in names if name not in (*_OWN, *_WORKSHOP)]
        sections = {**_COMMANDS, _OTHERS: others}
        width = max(map(len, names))
        for title, group in sections.items():
            if rows := [(name.ljust(width), self._help(ctx, name)) for name in group if name in names]:
                with formatter.section(title):
                    formatter.write_dl(rows)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        known = name in _COMMANDS or ctx.resilient_parsing or name in (names := self.list_commands(ctx))
        if not known and name in _WORKSHOP:
            raise lab_needed(f"`eehal {name}`")
        if not known and not name.startswith("-"):
            meant = _OTHER_NAMES.get(name) or next(iter(get_close_matches(name, names, n=1)), "")
            ctx.fail(f"No such command {name!r}.{f' Did you mean {meant!r}?' if meant else ''}")
        return super().resolve_command(ctx, args)

    def _help(self, ctx: click.Context, name: str) -> str:
        if name in _OWN:
            return _OWN[name]
        try:
            command = _ADDED.get(name)
        except ReportedError as error:
            return f"({error.what.rstrip('.')})"  # one that is broken hides no other
        return command.short_help or command.get_short_help_str(80)


_COLLECT_AFTER = (100_000, 50, 50)
"""New objects before a garbage collection, then rounds; until a program tunes its interpreter."""


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="end-effector-hal")
def eehal() -> None:
    """Bring up a robot end-effector: described once, its UPPAAL file executed.

    Exit codes: 0 ok, 1 the run ended in a defined failure, 2 bad description or usage, 3 hardware or ROS not
    reachable, 4 a property does not hold.
    """


def main() -> None:
    """Run the command line; print every expected error as one sentence on stderr, or with ``--json`` as an object on
    stdout.
    """
    # what a start loads stays: looking at it again and again takes a tenth of the start
    gc.set_threshold(*_COLLECT_AFTER)
    _open_closed_streams()
    stdout, stderr = sys.stdout, sys.stderr
    sys.stderr = _Pipe(
        stderr, OSError
    )  # a message that nobody can read changes neither the work nor the exit code
    command = "".join(sys.argv[1:2])
    if command in _SERVING:
        sys.stdout = _Pipe(stdout, OSError)
    if command in _JUDGING:
        sys.stdout = _Pipe(stdout, BrokenPipeError)
        # all of it goes with the process: to look for what nothing refers to takes a tenth of a second
        atexit.register(gc.freeze)
    try:
        _main()
    except OSError as error:
        # an error of a file that was opened names it, and its opener reports it
        if error.errno not in _UNWRITABLE or error.filename is not None:
            raise
        click.echo(f"The output cannot be written: {error.strerror}.", err=True)
        _discard(stdout)
        sys.exit(UsageError.exit_code)
    finally:
        sys.stdout, sys.stderr = stdout, stderr


def _open_closed_streams() -> None:
    """Replace a closed standard stream by an empty one, so that no file that is opened later gets its number.

    It can only be read: writing to it fails, as on a full disk.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDONLY)
            os.set_inheritable(nowhere, nowhere == number)  # what this process starts has its streams as well
            raw = FileIO(nowhere, "r" if number == 0 else "w", closefd=False)
            setattr(sys, name, TextIOWrapper(raw, write_through=True))


class _Pipe:
    """A standard stream that may fail, such as an output whose reader ends early, as ``head`` does.

    The rest is discarded, and the exit code stays right.

    Args:
        failure: the errors after which the rest is discarded.
    """

    def __init__(self, stream: TextIO, failure: type[OSError]) -> None:
        self._stream, self._failure = stream, failure

    def write(self, text: str) -> int:
        """Write the text; discard it if the stream fails."""
        try:
            return self._stream.write(text)
        except self._failure:
            _discard(self._stream)
            return len(text)

    def flush(self) -> None:
        """Flush the stream; discard its content if the stream fails."""
        try:
            self._stream.flush()
        except self._failure:
            _discard(self._stream)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _discard(stream: TextIO) -> None:
    """Redirect the stream to /dev/null, so that its buffered content does not fail again when the interpreter ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def _main() -> None:
    try:
        # click hands back what a command gave to ctx.exit
        sys.exit(eehal(standalone_mode=False) or 0)
    except click.ClickException as error:
        if _wants_json():
            _report(UsageError(error.format_message()))
        else:
            error.show()
        sys.exit(UsageError.exit_code)
    except click.exceptions.Exit as exit_:
        sys.exit(exit_.exit_code)
    except click.Abort:
        sys.exit(130)
    except ReportedError as error:
        _report(error)
        sys.exit(error.exit_code)
    except ModuleNotFoundError as error:
        missing = missing_extra("This command needs", error) or _other_system(error)
        if missing is None:
            raise
        _report(missing)
        sys.exit(missing.exit_code)
    except (MemoryError, RuntimeError) as error:
        what = "memory" if isinstance(error, MemoryError) else "thread"
        if what == "thread" and str(error) != "can't start new thread":
            raise
        lacking = ReportedError(f"The system gives this program no more {what}.", todo=_LIMITS)
        _report(lacking)
        sys.exit(lacking.exit_code)
    except BrokenPipeError:
        # the reader of our output has gone; there is nobody to tell
        sys.stderr.close()
        sys.exit(0)


def _other_system(error: ModuleNotFoundError) -> UsageError | None:
    if error.name not in _LINUX:
        return None
    return UsageError(f"This command needs Linux: there is no module {error.name} here.")


def _wants_json() -> bool:
    """Return whether ``--json`` is among the arguments; they are not parsed yet, since an error may come earlier."""
    return "--json" in sys.argv[1:]


def _report(error: ReportedError) -> None:
    if not _wants_json():
        click.echo(error.sentence, err=True)
        return
    # in one line: what prints JSON lines may end with it
    faults = [fault.as_json() for fault in error.diagnostics]
    print_line(ok=False, exit_code=error.exit_code, faults=faults)
