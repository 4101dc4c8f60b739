"""``eehal run`` and ``eehal serve``: run one tool in this terminal or as a service, without ROS."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from end_effector_hal.cli._completion import completed, session_words
from end_effector_hal.cli._options import end_in_order, until_ended
from end_effector_hal.errors import NotReadyError, ReportedError, UsageError

from ._opening import NOT_SIMULATED, Wanted, open_tool, tool_options

if TYPE_CHECKING:
    from end_effector_hal.control import Answer
    from end_effector_hal.runtime import EndEffector

LOOK_S = 0.5


@click.command("run")
@tool_options
@click.option(
    "--script",
    shell_complete=completed(session_words, separator=";"),
    help="Commands instead of the prompt, such as 'lock; grip; wait 2; drop'.",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print JSON lines: states, transitions, alarms, results."
)
def run(script: str | None, as_json: bool, **options: Any) -> None:
    """Give commands to one tool: lock, unlock, grip, drop, cancel, resume, stop, arm, reset, reload, wait SECONDS,
    status, help, quit.

    The line arbiter of the tool (`eehal arbiter DESCRIPTION`) must run. With --simulate no other program is needed,
    and the command `scenario S` causes a fault: a leak, a stuck valve, a silent link (`scenario nominal` ends it). At
    the prompt, cancel, stop and status are possible while a command runs; any other command waits for its end. In a
    script a command followed by `&` continues in the background, so that it can be cancelled: 'grip &; wait 3;
    cancel'. Quitting releases no held part; Ctrl-C and SIGTERM do what the description declares (`endings: sigterm`).
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.runtime import read_script
    from end_effector_hal.wires import now_us

    from ._session import CommandThread, Prompt, RunSession
    from ._voices import JsonLines, Words

    wanted = Wanted(**options)
    orders = read_script(script) if script is not None else None
    if not wanted.simulate and any(order.scenario for order in orders or ()):
        raise UsageError(NOT_SIMULATED, todo="Add --simulate.")
    begun, succeeded = now_us(), True
    terminal = sys.stdout.isatty() and not as_json
    prompt = Prompt(shown=sys.stdin.isatty() and not as_json)
    thread = CommandThread()
    voice = JsonLines(begun, prompt.write) if as_json else Words(prompt.write, timed=terminal, begun=begun)
    interactive = orders is None and prompt.shown
    commands = iter(prompt.commands(voice.error) if orders is None else orders)
    record = wanted.own_folder()
    end_in_order()
    reloads = True
    while reloads:
        with ExitStack() as stack:
            opened = open_tool(stack, wanted, load_tool(wanted.description), record, voice, shown=terminal)
            reload = partial(
                _reload,
                wanted.description,
                opened.tool,
                simulate=wanted.simulate,
                recorded=record is not None,
            )
            session = RunSession(
                opened.tool, voice, opened.changes, opened.choose, reload, thread, prompt.end
            )
            succeeded = session.play(commands, interactive=interactive) and succeeded
            reloads = session.reloads
    if prompt.lost is not None:
        raise prompt.lost
    sys.exit(0 if succeeded else 1)


def _reload(description: Path, tool: EndEffector, *, simulate: bool, recorded: bool) -> Answer:
    """Return whether this run may continue with the changed description; first the tool must be brought to rest."""
    answer = tool.stand_still()
    if answer.accepted and not (answer := _reload_file(description, tool, simulate, recorded)).accepted:
        tool.go_on()
    return answer


def _reload_file(description: Path, tool: EndEffector, simulate: bool, recorded: bool) -> Answer:
    """Return whether the changed file can be used; a simulated line arbiter restarts with it and loses its latched
    faults.
    """
    from end_effector_hal.arbiter import ArbiterClient
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.control import Answer
    from end_effector_hal.description import socket_path
    from end_effector_hal.runtime import reload_answer

    if recorded:
        return Answer(False, "A recording is of one description: end this run, and begin another folder.")
    if simulate:
        try:
            load_tool(description)
            with ArbiterClient(socket_path(tool.description), "reload", patience_s=0) as arbiter:
                faults = arbiter.status()["faults"].values()
        except ReportedError as error:
            return Answer(False, str(error))
        if faults:
            what = " ".join(map(str, faults))
            return Answer(
                False, f"A simulated line arbiter forgets its faults in a reload: reset them first. {what}"
            )
        return Answer(True)
    return reload_answer(tool.description)


@click.command("serve")
@tool_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines: states, transitions, alarms.")
def serve(as_json: bool, **options: Any) -> None:
    """Run the tool of a DESCRIPTION until SIGTERM or Ctrl-C, and let other programs command it.

    \b
    eehal do DESCRIPTION 'lock; grip'      gives commands, from any terminal of this machine
    eehal status DESCRIPTION               shows its state
    eehal page DESCRIPTION                 shows it in a browser
    EndEffector.connect(DESCRIPTION)       in Python

    The death of one of these programs does not affect the tool: a grip continues. The line arbiter of the tool
    (`eehal arbiter DESCRIPTION`) must run. With --simulate no arbiter is needed; the service prints the path of the
    simulated tool, which these programs need then. The service prints the same lines as `eehal run`; under systemd
    they are in the journal with fields (`journalctl EEHAL_TOOL=NAME EEHAL_EVENT=TimedOut`). At its end the line
    arbiter does what the description declares (`endings: sigterm`).

    Exit codes: 0 ended by SIGTERM, SIGHUP or Ctrl-C; 1 the program of the tool has failed; 2 the description has a
    fault; 3 the line arbiter or the sensors cannot be reached.
    """
    from end_effector_hal.codecs import load_tool

    from ._journal import journal_of
    from ._voices import JsonLines, Words, ignore_broken_output

    wanted = Wanted(**options)
    loaded = load_tool(wanted.description)
    voice = JsonLines() if as_json else Words(journal=journal_of(loaded.name))
    record, ended = wanted.own_folder(), until_ended()
    with ExitStack() as stack:
        tool = open_tool(stack, wanted, loaded, record, voice, shown=False).tool
        if not as_json:
            ignore_broken_output(click.echo)(
                f"{tool.description.name} is served: eehal do {tool.description.source} status"
            )
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
