"""``python -m tools.board``: plays a scenario on the emulated Verdin."""

from __future__ import annotations

from pathlib import Path

import click

from end_effector_hal.cli import PathName, end_in_order
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import profile_path
from end_effector_lab.commands import (
    chosen,
    console,
    json_option,
    no_figures_option,
    only_option,
    tell,
)
from tools import run
from tools.board import BoardProgress, board_parts, need_its_wires, play_on_board


@click.command("board")
@click.argument("description", required=False, type=PathName())
@click.option("--no-ros", is_flag=True, help="Without ROS: quicker, and the ROS messages are not needed.")
@only_option(default=["nominal"], show_default=True)
@no_figures_option
@click.option(
    "-o",
    "--output",
    default="runs",
    show_default=True,
    type=PathName(),
    help="Folder that receives board-NAME for each scenario.",
)
@click.option("--build-only", is_flag=True, help="Download and build the board's parts; print their folder.")
@json_option
def command(
    description: Path | None,
    no_ros: bool,
    only: tuple[str, ...],
    no_figures: bool,
    output: Path,
    build_only: bool,
    as_json: bool,
) -> None:
    """Play a scenario on an emulated Verdin iMX8M Plus on Dahlia, and judge the recording.

    QEMU boots Debian's arm64 kernel with the board's own device tree; the HAL runs inside, on its GPIO lines and its
    UART, and the testbench outside. The board is built once, from Debian's packages, in
    ${XDG_CACHE_HOME:-~/.cache}/end-effector-hal/board; nothing is installed and no root is needed. Its clock counts
    executed instructions: a busy machine slows it down without changing its recordings.

    Without DESCRIPTION: the shipped tool. Exit code 1: a scenario did not run as expected; 3: something is missing.
    """
    end_in_order()
    loaded = load_tool(description or profile_path())
    need_its_wires(loaded)
    picked = chosen(loaded, only, everything=True)
    progress = console(stderr=True)
    parts = board_parts(lambda text: progress.print(text, highlight=False, soft_wrap=True))
    if build_only:
        click.echo(parts)
        return
    figures = not no_figures
    reports = []
    for scenario in picked:
        folder = output / f"board-{scenario.name}"
        with BoardProgress(console(stderr=True, quiet=as_json), scenario.name, folder / "events") as shown:
            report = play_on_board(
                scenario,
                loaded,
                parts,
                folder,
                ros=not no_ros,
                figures=figures,
                while_running=shown.update,
            )
        reports.append(report)
    tell(reports, as_json=as_json)


if __name__ == "__main__":
    run(command)
