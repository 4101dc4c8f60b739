"""``eehal arbiter``, ``stop``, ``reset`` and ``reload``: the line arbiter, and requests from any terminal."""

from __future__ import annotations

import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import click

from end_effector_hal.arbiter import ArbiterClient, run_arbiter
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import socket_path, tool_path
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.wires import processors_awake

from ._completion import completed, profiles
from ._options import PathName
from ._output import print_document


@click.command()
@click.argument("description", type=PathName(), default=None, required=False)
@click.option(
    "--profile",
    default="",
    shell_complete=completed(profiles),
    help="Name of a shipped tool, instead of a description.",
)
@click.option("--socket", type=PathName(), help="Unix socket to serve; default: the description's.")
@click.option(
    "--journal",
    type=PathName(file_okay=False, exists=True),
    help="Folder that survives a loss of power; default: $STATE_DIRECTORY, else that of the socket.",
)
@click.option(
    "--group", help="Group whose members may command the lines; default: the group of this process."
)
@click.option(
    "--keep-awake",
    is_flag=True,
    help="Keep the processors from deep sleep: every reaction is shorter, and the machine uses more power.",
)
def arbiter(
    description: Path | None,
    profile: str,
    socket: Path | None,
    journal: Path | None,
    group: str | None,
    *,
    keep_awake: bool,
) -> None:
    """Own all output lines of a tool (in one request) and serve them on a Unix socket.

    The tool is named by its DESCRIPTION or by --profile; there is no default.

    Lines that are outputs already keep their level; inputs become inactive outputs. When a client dies, the arbiter
    executes its last will. The lines keep their level when the arbiter ends. The arbiter keeps latched faults in a
    journal, and last wills in the session record beside the socket, for the next arbiter.
    """
    path = tool_path(description or "", profile, how="DESCRIPTION or --profile NAME")
    with processors_awake() if keep_awake else nullcontext():
        run_arbiter(load_tool(path), socket, journal, group)


@click.command("stop")
@click.argument("description", type=PathName())
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def stop(description: Path, as_json: bool) -> None:
    """Latch a stop of the tool of a DESCRIPTION: nothing is activated until a reset. It is not a safety function.

    The line arbiter latches the stop like an open e-stop (IL-13), also through a restart, and refuses every activation
    from then on. A program that executes a grip cancels it within half a second, and does what the description
    declares for a cancel (`endings`); a held part stays held. `eehal reset` ends the stop, and so does a reset by
    `eehal do`, at the prompt, through ROS or on the page.

    Exit codes: 0 the stop is latched, 3 the line arbiter cannot be reached.
    """
    from end_effector_hal.runtime import latch_stop

    with ArbiterClient(socket_path(load_tool(description)), "eehal stop", patience_s=0) as arbiter:
        what = latch_stop(arbiter)
    if as_json:
        print_document({"ok": True, "stopped": True, "reason": what})
    else:
        click.echo(f"{what} To end the stop: eehal reset {description}")


@click.command("reset")
@click.argument("description", type=PathName())
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def reset(description: Path, as_json: bool) -> None:
    """Clear what the line arbiter of a DESCRIPTION has latched: a stop, an e-stop that is closed again, other faults.

    A fault whose cause persists stays latched. Faults that a program latches itself (a sensor fault of the tool
    changer, an alarm about a held part) are cleared by `eehal do DESCRIPTION reset`, at the prompt, through ROS or on
    the page; GRIP_ERROR and RELEASE_ERROR need a Drop, or after a loss a resume. A reset activates nothing.

    Exit codes: 0 the line arbiter has no latched fault left, 1 a fault stays, 3 the arbiter cannot be reached.
    """
    stays = ""
    with ArbiterClient(socket_path(load_tool(description)), "eehal reset", patience_s=0) as arbiter:
        try:
            if left := arbiter.reset():
                stays = f"{' '.join(left.values())} Clear it with: eehal do {description} reset"
        except LineRefusedError as error:
            stays = str(error)
    if as_json:
        print_document({"ok": not stays, "reason": stays})
    else:
        click.echo(stays or "The line arbiter has nothing latched any more.", err=bool(stays))
    sys.exit(1 if stays else 0)


GRANTED = "The description is valid and can be loaded: the tool is at rest."


@click.command("reload", context_settings={"ignore_unknown_options": True})
@click.argument("description", type=PathName())
@click.argument("restart", nargs=-1, type=click.UNPROCESSED)
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def reload(description: Path, restart: tuple[str, ...], as_json: bool) -> None:
    """Check a changed DESCRIPTION and, if the running HAL accepts it, call RESTART, which restarts the HAL with it.

    \b
    eehal reload tool.yaml                                        only prints whether it would be accepted now
    eehal reload tool.yaml -- systemctl restart eehal@tool        a service (`systemctl reload eehal@tool` does it)

    The file is checked first. Then the running HAL is asked: it refuses while a part is held, a command or maintenance
    is under way, or an error is latched, and where what the line arbiter was started with would change (outputs, their
    interlocks, its own inputs and buses). In each of these cases nothing happens, and the description that runs stays
    in force. If the HAL agrees, it begins no activation for 30 s, until RESTART has ended it or failed. The restarted
    HAL adopts the lines as they are. In `eehal run` the command `reload` does all of this.

    Exit codes: 0 done, or possible; 1 refused, or RESTART failed; 2 the description has a fault; 3 no HAL runs.
    """
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
