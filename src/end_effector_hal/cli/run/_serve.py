"""``eehal serve``: runs a tool as a service, without ROS and without a prompt."""

from __future__ import annotations

import signal
import sys
import threading
from contextlib import ExitStack
from typing import Any

import click

from end_effector_hal.errors import NotReadyError

from ._opening import Wanted, open_tool, tool_options

LOOK_S = 0.5


@click.command("serve")
@tool_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines: states, transitions, alarms.")
def command(as_json: bool, **options: Any) -> None:
    """Run the tool of a DESCRIPTION until SIGTERM or Ctrl-C, and let other programs command it.

    \b
    eehal do DESCRIPTION 'lock; grip'      gives commands, from any terminal of this machine
    eehal status DESCRIPTION               shows its state
    eehal page DESCRIPTION                 shows it in a browser
    EndEffector.connect(DESCRIPTION)       in Python

    The death of one of these programs does not affect the tool: a grip continues. The line arbiter of the tool
    (`eehal arbiter DESCRIPTION`) must run. With --simulate no arbiter is needed; the service prints the path of the
    simulated tool, which these programs need then. The service prints the same lines as `eehal run`. At its end the
    line arbiter does what the description declares (`endings: sigterm`).

    Exit codes: 0 ended by SIGTERM, SIGHUP or Ctrl-C; 1 the program of the tool has failed; 2 the description has a
    fault; 3 the line arbiter or the sensors cannot be reached.
    """
    from ._voices import JsonLines, Words

    voice = JsonLines() if as_json else Words()
    wanted, ended = Wanted(**options), threading.Event()
    record = wanted.own_folder()
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    with ExitStack() as stack:
        tool = open_tool(stack, wanted, record, voice, shown=False).tool
        if not as_json:
            click.echo(f"{tool.description.name} is served: eehal do {tool.description.source} status")
        while tool.alive and not ended.wait(LOOK_S):
            pass
        said = tool.ending()
        tool.close()
        if said:
            voice.ending(said)  # last: its listeners have printed the statuses
        if not ended.is_set():
            voice.error(
                NotReadyError(
                    f"The program of {tool.description.name} has failed.", todo="The log has the reason."
                )
            )
    sys.exit(0 if ended.is_set() else 1)
