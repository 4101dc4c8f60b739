"""``eehal reload``: checks whether the running HAL can be restarted with the changed description."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import click

from end_effector_hal.cli._json_output import print_document
from end_effector_hal.cli._options import PathName

GRANTED = "The description is valid and can be loaded: the tool is at rest."


@click.command("reload", context_settings={"ignore_unknown_options": True})
@click.argument("description", type=PathName())
@click.argument("restart", nargs=-1, type=click.UNPROCESSED)
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def command(description: Path, restart: tuple[str, ...], as_json: bool) -> None:
    """Check a changed DESCRIPTION and, if the running HAL accepts it, call RESTART, which restarts the HAL with it.

    \b
    eehal reload tool.yaml                                        only prints whether it would be accepted now
    eehal reload tool.yaml -- systemctl restart eehal-hal         nodes of ROS (`systemctl reload eehal-hal` does it)

    The file is checked first. Then the running HAL is asked: it refuses while a part is held, a command or maintenance
    is under way, or an error is latched, and where what the line arbiter was started with would change (outputs, their
    interlocks, its own inputs and buses). In each of these cases nothing happens, and the description that runs stays
    in force. If the HAL agrees, it begins no activation for 30 s, until RESTART has ended it or failed. The restarted
    HAL adopts the lines as they are. In `eehal run` the command `reload` does all of this.

    Exit codes: 0 done, or possible; 1 refused, or RESTART failed; 2 the description has a fault; 3 no HAL runs.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.control import Answer
    from end_effector_hal.runtime.stream import GO_ON, RELOAD, ask_program, program_socket

    path = program_socket(load_tool(description))
    answer = ask_program(path, RELOAD)
    code = 0 if answer.accepted else 1 if answer.decided else 3
    if answer.accepted:
        answer = Answer(True, GRANTED)
        if failed := subprocess.call(restart) if restart else 0:
            code, answer = 1, Answer(False, f"{restart[0]} failed ({failed}): the HAL goes on as it is.")
        if failed or not restart:
            ask_program(path, GO_ON)
    if as_json:
        print_document({"ok": not code, "reason": answer.reason})
    else:
        click.echo(answer.reason, err=bool(code))
    sys.exit(code)
