"""The demo: plays one scenario after the other with fresh hardware, records, judges and draws it."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import run_info
from end_effector_hal.wires.lines import Edge
from end_effector_lab.figures import STYLES, RecordedRun

from ._judge import answered, judge, read_edges, replayed
from ._progress import Progress
from ._report import Report
from ._scenario import DemoScenario
from ._world import DESCRIPTION, LINES, Drive, World


def run_demo(
    description: Description,
    scenarios: Sequence[DemoScenario],
    output: Path,
    *,
    drive: Drive,
    progress: Console,
    own_wires: bool = False,
    figures: bool = True,
    seed: int = 0,
) -> Iterator[Report]:
    """Play scenarios one after the other; yield each report when its scenario has been played and drawn.

    Args:
        description: the tool; it gets virtual lines and a pty, unless ``own_wires``.
        scenarios: the scenarios to play.
        output: receives a folder for each scenario.
        own_wires: use the lines and the port of the description; the device at their other end plays the scenario.
        figures: whether to draw figures.
        seed: seed of the noise and the dead times of the testbench; ignored on own wires.

    Raises:
        RosError: ROS is requested but not available.
        ReportedError: a process does not start, or a folder cannot be written.
    """
    drive.check()
    for number, scenario in enumerate(scenarios, start=1):
        folder = fresh_folder(output / scenario.name)
        begun = time.monotonic()
        info = run_info(description, scenario=scenario.bench, seed=None if own_wires else seed, ros=drive.ros)
        title = f"[{number}/{len(scenarios)}] {scenario.name}"
        with (
            Progress(progress, title, folder / "states.csv", info),
            World(description, scenario.bench, folder, own_wires=own_wires, seed=seed) as world,
        ):
            info.write(folder)
            drive.play(world, scenario.script, scenario.longest_s(world.description))
        edges = None if own_wires else read_edges(folder / LINES)
        report = report_on(scenario, description, folder, edges, figures=figures)
        yield replace(report, seconds=time.monotonic() - begun)


def report_on(
    scenario: DemoScenario,
    description: Description,
    folder: Path,
    edges: Sequence[Edge] | None,
    *,
    figures: bool,
) -> Report:
    """Return the report on a recording and its traces, and draw the recording if ``figures``; see `judge`."""
    run = RecordedRun.read(folder / "states.csv")
    if run.log.rows and figures:
        from end_effector_lab.figures import save  # with matplotlib

        for style in STYLES:
            figure = run.figure(style)
            for suffix in ("png", "svg"):
                save(figure, folder / f"{style}.{suffix}")
    report = judge(scenario, description, run.log, run.info, edges)
    return replace(report, findings=(*report.findings, answered(folder), replayed(folder)), folder=folder)


def fresh_folder(folder: Path) -> Path:
    """Return an empty folder; the results of an earlier demo in it are deleted.

    Raises:
        UsageError: the folder contains other files, or cannot be made.
    """
    with os_errors("The folder cannot be made", folder):
        if folder.exists() and any(folder.iterdir()) and not (folder / DESCRIPTION).exists():
            raise UsageError(
                "This folder contains files that `eehal demo` did not write.",
                where=str(folder),
                todo="Choose another with -o.",
            )
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    return folder
