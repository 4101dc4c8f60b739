"""Open the tool of ``eehal run`` and ``eehal serve``: their options, the simulation, and the recording."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, TypeVar

import click

from end_effector_hal._extras import lab_installed
from end_effector_hal.cli._completion import completed, scenarios
from end_effector_hal.cli._options import PathName, seed_option
from end_effector_hal.errors import ArbiterError, NotReadyError, UsageError, os_errors

if TYPE_CHECKING:
    from end_effector_hal.control import Status
    from end_effector_hal.description import Description
    from end_effector_hal.recording import Recording
    from end_effector_hal.runtime import EndEffector, Tool

    from ._voices import Changes, Voice

READY_S = 10.0
RECORDING = "that records"
NOT_SIMULATED = "A scenario is for a simulated tool: nothing makes a real one fail."
Decorated = TypeVar("Decorated", bound=Callable[..., object])


def limit_options(command: Decorated) -> Decorated:
    """Add the options that limit a recording."""
    segment = click.option(
        "--segment-mb", default=64.0, show_default=True, help="Size of one segment file, in MB."
    )
    keep = click.option(
        "--keep-mb",
        default=1000.0,
        show_default=True,
        help="Size limit of the whole recording, in MB; the oldest segments are removed.",
    )
    return segment(keep(command))


def tool_options(command: Decorated) -> Decorated:
    """Add the options of a command that runs a tool."""
    for option in reversed((
        click.argument("description", type=PathName()),
        click.option(
            "--simulate",
            is_flag=True,
            hidden=not lab_installed(),
            help="Without hardware: virtual lines, with a testbench and a line arbiter of its own that end with it.",
        ),
        click.option(
            "--scenario",
            metavar="S",
            hidden=not lab_installed(),
            shell_complete=completed(scenarios, separator=","),
            help="With --simulate: what goes wrong, such as leak:top_vacuum; `eehal testbench --list` lists them.",
        ),
        seed_option(
            default=None, help="With --simulate: seed of the random noise and dead times.  [default: 0]"
        ),
        click.option("--record", type=PathName(), help="Folder for the recording of the run."),
        limit_options,
    )):  # fmt: skip
        command = option(command)
    return command


@dataclass(frozen=True)
class Wanted:
    """The values of the options.

    Attributes:
        description: path of the description.
        simulate: whether the hardware is simulated.
        scenario: what goes wrong in the simulation; None: nothing.
        seed: seed of the simulation; None: 0.
        record: folder of the recording; None: nothing is recorded.
        segment_mb, keep_mb: the recording limits, MB.
    """

    description: Path
    simulate: bool
    scenario: str | None
    seed: int | None
    record: Path | None
    segment_mb: float
    keep_mb: float

    def own_folder(self) -> Path | None:
        """Return the folder that this run records into, which can be written.

        Raises:
            UsageError: an option is for a simulated tool, or the folder cannot be written.
        """
        if not self.simulate and self.scenario is not None:
            raise UsageError(NOT_SIMULATED, todo="Add --simulate.")
        if not self.simulate and self.seed is not None:
            raise UsageError(
                "--seed is for a simulated tool: a real one has nothing random.", todo="Add --simulate."
            )
        if self.record is None:
            return None
        return own_folder(self.record)


@dataclass(frozen=True)
class Opened:
    """A tool at work; ``choose`` selects another scenario, or raises UsageError."""

    tool: EndEffector
    changes: Changes
    choose: Callable[[str], None]


def open_tool(
    stack: ExitStack, wanted: Wanted, loaded: Description, record: Path | None, voice: Voice, *, shown: bool
) -> Opened:
    """Open a tool on a stack that closes it, and wait until it is ready.

    A tool that does not become ready is opened nevertheless, so that a held part can be dropped.

    Args:
        stack: closes everything.
        wanted: the options.
        loaded: the description that they name.
        record: the folder of the recording; None: nothing is recorded.
        voice: prints what happens.
        shown: whether the progress of the start is shown.
    """
    from end_effector_hal.cli._output import Progress
    from end_effector_hal.recording import Recording, RecordingLimits
    from end_effector_hal.runtime import EndEffector
    from end_effector_hal.wires import tune_interpreter

    from ._causes import Causes
    from ._simulation import simulated
    from ._voices import Changes, JsonLines

    limits = RecordingLimits.of_megabytes(wanted.segment_mb, wanted.keep_mb)
    scenario, seed = wanted.scenario or "nominal", wanted.seed or 0
    choose: Callable[[str], None] = refuse_scenario
    with Progress(
        "The simulation is starting" if wanted.simulate else "The tool is starting", shown=shown
    ) as progress:
        if wanted.simulate:
            hardware = stack.enter_context(simulated(loaded, scenario, seed))
            loaded, choose = hardware.description, hardware.choose
            progress.clear()
            click.echo("Simulated: virtual lines and a testbench; nothing real moves.", err=True)
            click.echo(f"While this runs, a page shows it: eehal page {loaded.source}", err=True)
            progress("The tool is starting")
        causes = Causes(loaded) if isinstance(voice, JsonLines) else None
        observe = None if causes is None else causes.take
        try:
            tool = stack.enter_context(EndEffector(loaded, traces=record, limits=limits, observe=observe))
        except ArbiterError as error:
            if isinstance(error.__cause__, (FileNotFoundError, ConnectionRefusedError)):  # none runs
                raise _with_commands(error, wanted.description) from error
            raise
    if record is not None:
        played = (scenario, seed) if wanted.simulate else ("", None)
        recording = Recording(record, loaded, scenario=played[0], seed=played[1], limits=limits)
        record_into(tool, stack.enter_context(recording))
        stack.callback(tool.close)  # its last states are recorded
    changes = Changes(loaded, voice, causes)
    tool.subscribe(changes.status)
    tune_interpreter()  # before frames come: it takes so long that readings would turn stale
    tool.start()
    try:
        tool.wait_ready(READY_S)
    except NotReadyError as error:
        voice.error(error)
    return Opened(tool, changes, choose)


def refuse_scenario(_: str) -> None:
    """Refuse a scenario for a real tool."""
    raise UsageError(NOT_SIMULATED, todo="Start it with --simulate.")


def _with_commands(error: ArbiterError, description: Path) -> ArbiterError:
    """Return the error with the two commands that help, ready to be typed."""
    return ArbiterError(
        error.what,
        where=error.where,
        todo=f"Start it in another terminal: eehal arbiter {description}. Without hardware: eehal "
        f"{click.get_current_context().info_name} --simulate {description}.",
    )


def own_folder(folder: Path) -> Path:
    """Return the folder, or a new one beside it if it already contains a recording: a folder holds one run, and no run
    is refused because of that.

    Raises:
        UsageError: the folder cannot be written.
    """
    own, number = folder, 1
    with os_errors("The recording cannot be written", folder, todo="Name another folder."):
        while any(next(own.glob(files), None) for files in ("states*.csv", "*.mcap")):
            own = folder.with_name(f"{folder.name}-{(number := number + 1)}")
    if own != folder:
        click.echo(f"{folder} holds a recording already: this run is recorded into {own}.", err=True)
    _try_to_write(own)
    return own


def _try_to_write(folder: Path) -> None:
    """Check that the folder can be written, so that the error appears at the start."""
    with os_errors("The recording cannot be written", folder, todo="Name another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()


def record_into(tool: Tool, recording: Recording) -> None:
    """Record every status and frame of a tool; call it before the tool starts or reconnects."""

    def state(status: Status) -> None:
        recording.state(status.at, status.ee, status.command, status.actuators)
        recording.tool_changer(status.at, status.changer)
        recording.part(status.at, status.part)
        recording.alarms(status.at, status.alarms)
        recording.events(status.at, status.events)

    tool.subscribe(state, name=RECORDING)
    tool.subscribe_frames(lambda frame: recording.values(frame.at, frame.values), name=RECORDING)
