"""``eehal do``, ``status`` and ``record``: clients of a tool that another process runs."""

from __future__ import annotations

import sys
from pathlib import Path
from queue import SimpleQueue

import click

from end_effector_hal.cli._completion import client_words, completed
from end_effector_hal.cli._options import PathName, end_in_order, until_ended
from end_effector_hal.errors import UsageError

from ._opening import limit_options, own_folder, record_into


@click.command("do")
@click.argument("description", type=PathName())
@click.argument("commands", shell_complete=completed(client_words, separator=";"))
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines: states, log, alarms, results.")
def do(description: Path, commands: str, as_json: bool) -> None:
    """Give COMMANDS, such as 'lock; grip', to the tool of a DESCRIPTION, which another program runs.

    `eehal serve`, `eehal run` or the ROS nodes must run the tool. The commands are those of `eehal run --script`:
    lock, unlock, grip, drop, cancel, resume, stop, arm, reset, set OUTPUT on|off, wait SECONDS, status. A command
    begins when the one before it has ended; a command followed by `&` continues in the background. The end or the
    death of this program does not affect the tool: a running command continues.

    Exit codes: 0 all commands succeeded, 1 a command did not succeed, 2 the description or a command has a fault, 3 no
    HAL runs the tool.
    """
    from end_effector_hal.control import Answer
    from end_effector_hal.runtime import EndEffector, read_script
    from end_effector_hal.wires import now_us

    from ._session import CommandThread, Prompt, RunSession
    from ._voices import Changes, JsonLines, Words

    orders, begun = read_script(commands), now_us()
    terminal = sys.stdout.isatty() and not as_json
    prompt = Prompt(shown=False)
    voice = JsonLines(begun, prompt.write) if as_json else Words(prompt.write, timed=terminal, begun=begun)
    elsewhere = Answer(False, f"The HAL must be restarted to load it: eehal reload {description} -- COMMAND")
    end_in_order()
    with EndEffector.connect(description) as tool:
        changes = Changes(tool.description, voice)
        changes.begin(tool.status)
        tool.subscribe(changes.status)
        session = RunSession(
            tool, voice, changes, _refuse_scenario, lambda: elsewhere, CommandThread(), prompt.end
        )
        succeeded = session.play(orders)
    sys.exit(0 if succeeded else 1)


def _refuse_scenario(_: str) -> None:
    raise UsageError(
        "`eehal do` chooses no scenario.",
        todo="Choose it on the page of the simulated tool, or with --scenario.",
    )


@click.command("status")
@click.argument("description", type=PathName())
@click.option("--follow", is_flag=True, help="Also print every later change, until Ctrl-C.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def status(description: Path, follow: bool, as_json: bool) -> None:
    """Print the state of the tool of a DESCRIPTION, the evidence of its actuators, and its alarms.

    `eehal serve`, `eehal run` or the ROS nodes must run the tool.

    Exit codes: 0 printed, 2 the description has a fault, 3 no HAL runs the tool.
    """
    from end_effector_hal.runtime import EndEffector

    from ._voices import Changes, JsonLines, Words

    broken = SimpleQueue[OSError]()

    def write(text: str, *, err: bool = False) -> None:
        try:
            click.echo(text, err=err)
        except OSError as error:  # to print is all that this command does
            broken.put(error)
            raise

    voice = JsonLines(write=write) if as_json else Words(write)
    end_in_order()
    with EndEffector.connect(description) as tool:
        now = tool.status
        voice.status(tool.description, now)
        if follow:
            changes = Changes(tool.description, voice)
            changes.begin(now)
            tool.subscribe(changes.status)
        if follow or not broken.empty():
            raise broken.get()


@click.command("record")
@click.argument("description", type=PathName())
@click.argument("folder", type=PathName())
@limit_options
def record(description: Path, folder: Path, segment_mb: float, keep_mb: float) -> None:
    """Record what the tool of a DESCRIPTION does into a FOLDER, until SIGTERM or Ctrl-C.

    `eehal serve`, `eehal run` or the ROS nodes must run the tool. This process records by itself: neither a full disk
    nor its death affects the tool. It records on when the tool is back. The trace that `eehal replay` needs is recorded
    by the program of the tool only: `eehal serve --record FOLDER`.

    Exit codes: 0 ended by SIGTERM, SIGHUP or Ctrl-C, 2 the description has a fault, or the folder cannot be written, 3
    no HAL runs the tool.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.recording import Recording, RecordingLimits
    from end_effector_hal.runtime import EndEffector, RemoteTool

    ended = until_ended()
    with EndEffector.connect(description):
        pass  # a HAL runs it
    tool = RemoteTool(load_tool(description))
    limits = RecordingLimits.of_megabytes(segment_mb, keep_mb)
    with Recording(own := own_folder(folder), tool.description, limits=limits) as recording:
        record_into(tool, recording)
        tool.start()
        click.echo(f"{tool.description.name} is recorded into {own}.", err=True)
        ended.wait()
        tool.close()  # its last states are recorded
