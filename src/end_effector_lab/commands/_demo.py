"""``eehal demo``: plays the scenarios of the paper from end to end."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli import PathName, completed, end_in_order, print_document, seed_option
from end_effector_hal.errors import UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from end_effector_hal.description import Description
    from end_effector_lab.demo import DemoScenario, Report

WIDTH = 120
NAMES = ("nominal", "fails-once", "never-confirms", "cancel", "stuck-release", "unlock-lock")

# `make board` takes these options as well.
only_option = partial(
    click.option,
    "--only",
    multiple=True,
    metavar="NAME",
    shell_complete=completed(lambda _: NAMES),
    help=f"Only this scenario; may be given again. Of {', '.join(NAMES)} (with a tool changer).",
)
no_figures_option = click.option("--no-figures", is_flag=True, help="Record only; `eehal plot` draws.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print the reports as JSON.")


@click.command("demo", short_help="the three scenarios of the paper, with their figures")
@click.argument("description", required=False, type=PathName())
@click.option("--no-ros", is_flag=True, help="The same core, testbench and wires, without ROS.")
@click.option(
    "--ros",
    type=click.Choice(["1", "2"]),
    help="Which version of ROS; default: the one of this environment.",
)
@click.option("--five", is_flag=True, help="ROS 2: a process for each node, as the paper draws them.")
@click.option(
    "--all", "everything", is_flag=True, help="Also a cancel, a release that fails, unlock and lock."
)
@only_option()
@click.option(
    "--own-wires",
    is_flag=True,
    help="On the lines and the port of DESCRIPTION: a testbench at their other end plays the scenario.",
)
@seed_option(
    default=None,
    help="Seed of the random noise and dead times; run.json keeps it, so that a demo can be repeated.  [default: 0]",
)
@no_figures_option
@click.option(
    "-o",
    "--output",
    default="runs/demo",
    show_default=True,
    type=PathName(),
    help="Folder of the runs.",
)
@json_option
def command(
    description: Path | None,
    no_ros: bool,
    ros: str | None,
    five: bool,
    everything: bool,
    only: tuple[str, ...],
    own_wires: bool,
    seed: int | None,
    no_figures: bool,
    output: Path,
    as_json: bool,
) -> None:
    """Play the paper's three scenarios (Figs. 7, 8 and 9) and draw the recordings.

    For each scenario a virtual chip, the line arbiter and the testbench are started, and with ROS the nodes, the
    DataLogger and the Supervisor. With --own-wires there is no virtual chip, and the testbench (or the tool itself) is
    at the other end already. Without DESCRIPTION: the shipped tool. Exit code 1: a scenario did not run as expected,
    or a time-out or reset was not within 100 ms after its nominal time.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import profile_path
    from end_effector_lab.demo import Ros1, Ros2, WithoutRos, run_demo, unplayable

    end_in_order()
    if no_ros and (ros or five):
        raise UsageError("--no-ros excludes --ros and --five.")
    generation = ros or ("2" if five or importlib.util.find_spec("rclpy") else "1")
    if five and generation == "1":
        raise UsageError("--five is for ROS 2; in ROS 1 the nodes are always five processes.")
    drive = WithoutRos() if no_ros else Ros2(five=five) if generation == "2" else Ros1()
    loaded = load_tool(description or profile_path())
    picked = chosen(loaded, only, everything=everything)
    if own_wires and len({scenario.bench for scenario in picked}) > 1:
        raise UsageError("--own-wires plays one scenario at a time.", todo="Give --only NAME.")
    if own_wires and seed is not None:
        raise UsageError(
            "with --own-wires this command draws no random numbers.",
            todo="Give --seed to the testbench at their other end.",
        )
    progress = console(stderr=True)
    for name, why in unplayable(loaded).items() if everything and not only else ():
        progress.print(f"{name} is not played: {why}", highlight=False, soft_wrap=True)
    reports = list(
        run_demo(
            loaded,
            picked,
            output,
            drive=drive,
            progress=console(stderr=True, quiet=as_json),
            own_wires=own_wires,
            figures=not no_figures,
            seed=seed or 0,
        )
    )
    tell(reports, as_json=as_json)


def tell(reports: Sequence[Report], *, as_json: bool) -> None:
    """Print the reports; end the command with 1 if a scenario did not run as expected."""
    from end_effector_lab.demo import print_table

    if as_json:
        print_document({"reports": [report.as_json() for report in reports]})
    else:
        print_table(console(), reports)
    if not all(report.ok for report in reports):
        raise click.exceptions.Exit(1)


def chosen(description: Description, names: Sequence[str], *, everything: bool) -> list[DemoScenario]:
    """Return the scenarios with these names; without a name, the paper's three or all. Raises UsageError."""
    from end_effector_lab.demo import scenarios, unplayable

    known = scenarios(description, everything=everything or bool(names))
    by_name, left_out = {scenario.name: scenario for scenario in known}, unplayable(description)
    if unknown := [name for name in names if name not in by_name]:
        if why := [f"{name} cannot be played: {left_out[name]}" for name in unknown if name in left_out]:
            raise UsageError(why[0], where=description.where("link", "codec"))
        from end_effector_hal.description import did_you_mean

        guesses = " ".join(filter(None, (did_you_mean(name, by_name) for name in unknown)))
        todo = f"{guesses[:1].upper()}{guesses[1:]} There are: {', '.join(by_name)}.".lstrip()
        raise UsageError(f"there is no scenario {', '.join(unknown)}.", todo=todo)
    return [by_name[name] for name in names] if names else list(known)


def console(*, stderr: bool = False, quiet: bool = False) -> Console:
    """Return a console; without a terminal it has a fixed width, since a file has none."""
    from rich.console import Console

    console = Console(stderr=stderr, quiet=quiet)
    return console if console.is_terminal else Console(stderr=stderr, quiet=quiet, width=WIDTH)
