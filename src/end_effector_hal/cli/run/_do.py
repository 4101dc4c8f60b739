"""``eehal do``: gives commands to a tool that another process runs."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from end_effector_hal.cli._completion import completed, session_words
from end_effector_hal.cli._options import PathName, end_in_order

from ._opening import refuse_scenario


@click.command("do")
@click.argument("description", type=PathName())
@click.argument("commands", shell_complete=completed(session_words, separator=";"))
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines: states, alarms, results.")
def command(description: Path, commands: str, as_json: bool) -> None:
    """Give COMMANDS, such as 'lock; grip', to the tool of a DESCRIPTION that runs already.

    `eehal serve`, `eehal run` or the ROS nodes run it. The commands are those of `eehal run --script`: lock, unlock,
    grip, drop, cancel, stop, arm, reset, set OUTPUT on|off, wait SECONDS, status. Each waits for its end; one that is
    followed by `&` goes on in the background. To end this command, or to kill it, changes nothing about the tool: a
    command that runs goes on.

    Exit codes: 0 all succeeded, 1 one did not, 2 the description or a command has a fault, 3 no HAL runs the tool.
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
    elsewhere = Answer(False, f"Only its own process can load it: eehal reload {description}")
    end_in_order()
    with EndEffector.connect(description) as tool:
        changes = Changes(tool.description, voice)
        changes.begin(tool.status)
        tool.subscribe(changes.status)
        session = RunSession(
            tool, voice, changes, refuse_scenario, lambda: elsewhere, CommandThread(), prompt.end
        )
        succeeded = session.play(orders)
    sys.exit(0 if succeeded else 1)
