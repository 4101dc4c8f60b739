"""``eehal testbench``: simulates the hardware at the other end of the wires."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click

from end_effector_hal.cli import PathName, completed, print_document, seed_option, typed_tool


def _list_faults(*, as_json: bool) -> None:
    from end_effector_lab.testbench import FAULTS

    if as_json:
        print_document({"scenarios": [{"usage": each.usage, "meaning": each.meaning} for each in FAULTS]})
        return
    width = max(len(fault.usage) for fault in FAULTS)
    for fault in FAULTS:
        click.echo(f"{fault.usage:{width}}  {fault.meaning}")


def _faults(context: click.Context) -> Iterable[str]:
    from end_effector_lab.testbench import possible_faults

    return possible_faults(typed_tool(context))


@click.command("testbench", short_help="the simulated hardware at the other end of the wires")
@click.argument("description", required=False, type=PathName())
@click.option(
    "--scenario",
    default="nominal",
    metavar="S",
    shell_complete=completed(_faults, separator=","),
    help="What goes wrong; several with commas.",
)
@click.option("--list", "listed", is_flag=True, help="List the scenarios.")
@seed_option(default=0, help="Seed of the random noise and dead times.  [default: 0]")
@click.option(
    "--lines",
    metavar="WHERE",
    help="Where the lines are seen: virtual:PATH, rpi3, gpiod, gpiod:LINE=NAME,..., gpio-sim.  "
    "[default: the description's virtual chip]",
)
@click.option(
    "--port",
    metavar="PORT",
    help="Where frames are sent: a serial device, an address of this machine such as tcp://127.0.0.1:1502, or pty:PATH "
    "for a new pseudo-terminal with a link at PATH; of several links NAME=PORT,...  [default: the addresses "
    "of the description, and a pseudo-terminal at every other port; rpi3: /dev/serial0]",
)
@click.option(
    "--model",
    metavar="UNIT=NAME",
    help="Play a device on a commanded bus by its model, such as 9=robotiq-2f85; 9= plays the registers that the "
    "description declares; several with commas, of several links LINK:UNIT=NAME.  [default: the model of the device "
    "that an actuator names, else the registers]",
)
@click.option(
    "--prepare",
    metavar="FOLDER",
    type=PathName(file_okay=False),
    help="Only write the same tool on virtual lines and simulated ports into FOLDER, and print the path of this copy.",
)
@click.option("--power-cycle", is_flag=True, help="Reset the virtual chip: all lines become inputs.")
@click.option("--events", metavar="FILE", type=PathName(), help="Write edges and frames, JSON lines.")
@click.option("--verbose", is_flag=True, help="Print each edge.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def command(
    description: Path | None,
    scenario: str,
    listed: bool,
    seed: int,
    lines: str | None,
    port: str | None,
    model: str | None,
    prepare: Path | None,
    power_cycle: bool,
    events: Path | None,
    verbose: bool,
    as_json: bool,
) -> None:
    """Simulate the end-effector at the other end of the wires.

    The testbench reads the lines of DESCRIPTION (default: the shipped tool) and answers with sensor frames, until
    SIGTERM or Ctrl-C. While it runs, a line "scenario S" on standard input chooses another scenario, and "quit" ends
    it. The page of the tool (`eehal page`) can choose a scenario as well, if --lines and --port are those of
    DESCRIPTION.
    """
    if listed:
        _list_faults(as_json=as_json)
        return
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import profile_path
    from end_effector_lab.testbench import (
        chosen_models,
        open_inputs,
        open_ports,
        open_sensors,
        run_testbench,
        write_virtual_copy,
    )

    loaded = load_tool(description or profile_path())
    if prepare is not None:
        click.echo(write_virtual_copy(loaded, prepare))
        return
    run_testbench(
        loaded,
        open_inputs(lines, loaded, power_cycle=power_cycle, scenario=scenario),
        open_ports(port, loaded, lines),
        open_sensors(lines, loaded),
        models=chosen_models(model, loaded),
        scenario=scenario,
        seed=seed,
        verbose=verbose,
        as_json=as_json,
        events=events,
        # with other ends than those of the description it stands before another tool than a page of this one
        for_pages=lines is None and port is None,
    )
