"""Plays a scenario of the demo on the emulated board."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_lab.demo import DemoScenario, Report, fresh_folder, report_on
from end_effector_lab.testbench import edges_of

from ._errors import BoardError
from ._machine import run_board
from ._pins import pins_of

TOOL = "/opt/end-effector/tool/end_effector.yaml"
PORTS = ("/dev/verdin-uart1", "/dev/ttymxc0")


def need_its_wires(description: Description) -> None:
    """Raise UsageError if a tool uses lines or a port that the board does not have."""
    if description.lines.backend != "gpiod":
        raise UsageError(
            "this tool uses virtual lines, which the board does not have.",
            where=str(description.source),
            todo="The board has backend: gpiod.",
        )
    pins_of(description)
    ports = [link.port for link in description.links.values()] or ["for inputs of the board"]
    if missing := [port for port in ports if port not in PORTS]:
        raise UsageError(
            f"the board has no port {missing[0]}.",
            where=str(description.source),
            todo=f"Its sensor link is {PORTS[0]}.",
        )
    if len(ports) > 1:
        raise UsageError("the board has one port for sensors.", where=str(description.source))


def play_on_board(
    scenario: DemoScenario,
    description: Description,
    parts: Path,
    folder: Path,
    *,
    ros: bool,
    figures: bool = True,
    while_running: Callable[[], None] = lambda: None,
) -> Report:
    """Play a scenario, fetch the recording, and judge it by the pins that the testbench recorded.

    Args:
        scenario: the scenario.
        description: the tool; lines and port are those of the board.
        parts: see `board_parts`.
        folder: receives recording, traces, figures and logs.
        ros: whether to use all nodes, or `EndEffector` alone.
        figures: whether to draw them.
        while_running: called a few times a second.

    Raises:
        UsageError: see `need_its_wires`.
        BoardError: the job left no recording.
        ReportedError: see `run_board`.
    """
    need_its_wires(description)
    fresh_folder(folder)
    shutil.copyfile(description.source, folder / "end_effector.yaml")
    automata = description.automata_path.read_text(encoding="utf-8")
    files = {
        TOOL: description.source.read_text(encoding="utf-8"),
        str(Path(TOOL).parent / description.automata.file): automata,
    }
    options = f"--own-wires --no-figures --only {scenario.name}" + ("" if ros else " --no-ros")
    ended = run_board(
        parts,
        folder,
        f"eehal doctor {TOOL} --only lines; eehal-demo {TOOL} {options} -o /run/results",
        testbench=[str(description.source), "--scenario", scenario.bench],
        files={name.lstrip("/"): text for name, text in files.items()},
        ros=ros,
        while_running=while_running,
    )
    recorded = folder / "results" / scenario.name
    # 1: the board's own judgement, which does not know the pins
    if ended.code not in (0, 1) or not (recorded / "states.csv").exists():
        last = "".join(f"\n    {line}" for line in ended.output.strip().splitlines()[-8:])
        raise BoardError(f"The board left no recording in {folder}; it said:{last}")
    # links among its logs name places on the board
    shutil.copytree(recorded, folder, symlinks=True, dirs_exist_ok=True)
    shutil.rmtree(recorded)
    report = report_on(scenario, description, folder, edges_of(folder / "events"), figures=figures)
    return replace(report, seconds=ended.seconds)
