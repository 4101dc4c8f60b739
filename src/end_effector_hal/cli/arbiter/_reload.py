"""``eehal reload``: checks whether the running programs can be restarted with the changed description."""

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
    """Check a changed DESCRIPTION and, if the running programs accept it, call RESTART, which restarts them with it.

    \b
    eehal reload tool.yaml                                        only prints whether they would accept it now
    eehal reload tool.yaml -- systemctl restart eehal-hal         nodes of ROS (`systemctl reload eehal-hal` does it)

    The file is checked first. Then each running program is asked: it refuses while a part is held, a command or
    maintenance is under way, or an error is latched, and where what the line arbiter was started with would change
    (outputs, their interlocks, its own inputs and buses). In each of these cases nothing happens, and the description
    that runs stays in force. If all programs agree, none begins an activation for 30 s, until RESTART has ended them or
    failed. The restarted programs adopt the lines as they are. In `eehal run` the command `reload` does all of this.

    Exit codes: 0 done, or possible; 1 refused, or RESTART failed; 2 the description has a fault; 3 no program runs.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.control import PROGRAMS, Answer
    from end_effector_hal.runtime.stream import GO_ON, RELOAD, ask_program, program_socket

    tool = load_tool(description)
    sockets = {name: program_socket(tool, name) for name in PROGRAMS}
    answer, code, asked = Answer(True, GRANTED), 0, []
    for name, path in sockets.items():
        answer = ask_program(path, name, RELOAD)
        if not answer.accepted:
            code = 1 if answer.decided else 3
            break
        asked.append(name)
    if answer.accepted:
        answer = Answer(True, GRANTED)
        failed = subprocess.call(restart) if restart else 0
        code = 1 if failed else 0
        if failed:
            answer = Answer(False, f"{restart[0]} failed ({failed}): the programs go on as they are.")
    if code or not restart:
        for name in asked:
            ask_program(sockets[name], name, GO_ON)
    if as_json:
        print_document({"ok": not code, "reason": answer.reason})
    else:
        click.echo(answer.reason, err=bool(code))
    sys.exit(code)
