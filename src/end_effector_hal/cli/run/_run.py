"""``eehal run``: runs one tool in this terminal, without ROS."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING

import click

from end_effector_hal._extras import lab_installed
from end_effector_hal.cli._completion import completed, scenarios, session_words
from end_effector_hal.cli._options import PathName, end_in_order, seed_option
from end_effector_hal.errors import ArbiterError, NotReadyError, ReportedError, UsageError, os_errors

if TYPE_CHECKING:
    from end_effector_hal.control import Answer, Status
    from end_effector_hal.recording import Recording
    from end_effector_hal.runtime import EndEffector

READY_S = 10.0
RECORDING = "that records"
NOT_SIMULATED = "A scenario is for a simulated tool: nothing makes a real one fail."


@click.command("run")
@click.argument("description", type=PathName())
@click.option(
    "--script",
    shell_complete=completed(session_words, separator=";"),
    help="Commands instead of the prompt, such as 'lock; grip; wait 2; drop'.",
)
@click.option(
    "--simulate",
    is_flag=True,
    hidden=not lab_installed(),
    help="Without hardware: virtual lines, with a testbench and a line arbiter of its own that end with it.",
)
@click.option(
    "--scenario",
    metavar="S",
    hidden=not lab_installed(),
    shell_complete=completed(scenarios, separator=","),
    help="With --simulate: what goes wrong, such as leak:top_vacuum; `eehal testbench --list` lists them.",
)
@seed_option(default=None, help="With --simulate: seed of the random noise and dead times.  [default: 0]")
@click.option("--record", type=PathName(), help="Folder for the recording of the run.")
@click.option(
    "--segment-mb",
    default=64.0,
    show_default=True,
    help="Size of one segment file, in MB.",
)
@click.option(
    "--keep-mb",
    default=1000.0,
    show_default=True,
    help="Size limit of the whole recording, in MB; the oldest segments are removed.",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print JSON lines: states, transitions, alarms, results."
)
def command(
    description: Path,
    script: str | None,
    simulate: bool,
    scenario: str | None,
    seed: int | None,
    record: Path | None,
    segment_mb: float,
    keep_mb: float,
    as_json: bool,
) -> None:
    """Give commands to one tool: lock, unlock, grip, drop, cancel, stop, arm, reset, reload, wait SECONDS, status,
    help, quit.

    The line arbiter of the tool (`eehal arbiter DESCRIPTION`) must run. With --simulate no other program is needed,
    and the command `scenario S` causes a fault: a leak, a stuck valve, a silent link (`scenario nominal` ends it). At
    the prompt, cancel, stop and status are possible while a command runs; any other command waits for its end. In a
    script a command followed by `&` continues in the background, so that it can be cancelled: 'grip &; wait 3;
    cancel'. Quitting releases no held part; Ctrl-C and SIGTERM do what the description declares (`endings: sigterm`).
    """
    from end_effector_hal.cli._progress import Progress
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.recording import Recording, RecordingLimits
    from end_effector_hal.runtime import EndEffector, read_script
    from end_effector_hal.wires import now_us, tune_interpreter

    from ._causes import Causes
    from ._session import CommandThread, Prompt, RunSession
    from ._simulation import simulated
    from ._voices import Changes, JsonLines, Words

    limits = RecordingLimits.of_megabytes(segment_mb, keep_mb)
    orders = read_script(script) if script is not None else None
    if not simulate and (scenario is not None or any(order.scenario for order in orders or ())):
        raise UsageError(NOT_SIMULATED, todo="Add --simulate.")
    if not simulate and seed is not None:
        raise UsageError(
            "--seed is for a simulated tool: a real one has nothing random.", todo="Add --simulate."
        )
    begun, succeeded = now_us(), True
    terminal = sys.stdout.isatty() and not as_json
    prompt = Prompt(shown=sys.stdin.isatty() and not as_json)
    thread = CommandThread()
    voice = JsonLines(begun, prompt.write) if as_json else Words(prompt.write, timed=terminal, begun=begun)
    interactive = orders is None and prompt.shown
    commands = iter(prompt.commands(voice.error) if orders is None else orders)
    if record is not None:
        record = _own_folder(record)
        _try_to_write(record)
    end_in_order()
    reloads = True
    while reloads:
        loaded = load_tool(description)
        choose: Callable[[str], None] = _refuse_scenario
        with ExitStack() as stack:
            progress = Progress(
                "The simulation is starting" if simulate else "The tool is starting", shown=terminal
            )
            with progress:
                if simulate:
                    hardware = stack.enter_context(simulated(loaded, scenario or "nominal", seed or 0))
                    loaded, choose = hardware.description, hardware.choose
                    progress.clear()
                    click.echo("Simulated: virtual lines and a testbench; nothing real moves.", err=True)
                    click.echo(f"Live in a browser: eehal page {loaded.source}", err=True)
                    progress("The tool is starting")
                causes = Causes(loaded) if as_json else None
                observe = None if causes is None else causes.take
                try:
                    tool = stack.enter_context(
                        EndEffector(loaded, traces=record, limits=limits, observe=observe)
                    )
                except ArbiterError as error:
                    if isinstance(error.__cause__, (FileNotFoundError, ConnectionRefusedError)):  # none runs
                        raise _with_commands(error, description) from error
                    raise
            if record is not None:
                played = (scenario or "nominal", seed or 0) if simulate else ("", None)
                recording = Recording(record, loaded, scenario=played[0], seed=played[1], limits=limits)
                _record(tool, stack.enter_context(recording))
                stack.callback(tool.close)  # its last states are recorded
            changes = Changes(loaded, voice, causes)
            tool.subscribe(changes.status)
            tune_interpreter()  # before frames come: it takes so long that readings would turn stale
            tool.start()
            try:
                tool.wait_ready(READY_S)
            except NotReadyError as error:
                voice.error(error)  # what is held can be dropped all the same
            reload = partial(_reload, description, tool, simulate=simulate, recorded=record is not None)
            session = RunSession(tool, voice, changes, choose, reload, thread, prompt.end)
            succeeded = session.play(commands, interactive=interactive) and succeeded
            reloads = session.reloads
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


def _with_commands(error: ArbiterError, description: Path) -> ArbiterError:
    """Return the error with the two commands that help, ready to be typed."""
    return ArbiterError(
        error.what,
        where=error.where,
        todo=f"Start it in another terminal: eehal arbiter {description}. Without hardware: eehal run --simulate "
        f"{description}.",
    )


def _refuse_scenario(_: str) -> None:
    raise UsageError(NOT_SIMULATED, todo="Start it with --simulate.")


def _own_folder(folder: Path) -> Path:
    """Return the folder, or a new one beside it if it already contains a recording: a folder holds one run, and no run
    is refused because of that.
    """
    own, number = folder, 1
    with os_errors("The recording cannot be written", folder, todo="Name another folder."):
        while any(next(own.glob(files), None) for files in ("states*.csv", "*.mcap")):
            own = folder.with_name(f"{folder.name}-{(number := number + 1)}")
    if own != folder:
        click.echo(f"{folder} holds a recording already: this run is recorded into {own}.", err=True)
    return own


def _try_to_write(folder: Path) -> None:
    """Check that the folder can be written, so that the error appears at the start."""
    with os_errors("The recording cannot be written", folder, todo="Name another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()


def _record(tool: EndEffector, recording: Recording) -> None:
    def state(status: Status) -> None:
        recording.state(status.at, status.ee, status.command, status.actuators)
        recording.tool_changer(status.at, status.changer)
        recording.alarms(status.at, status.alarms)
        recording.events(status.at, status.events)

    tool.subscribe(state, name=RECORDING)
    tool.subscribe_frames(lambda frame: recording.values(frame.at, frame.values), name=RECORDING)
