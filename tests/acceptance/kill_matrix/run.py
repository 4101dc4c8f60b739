"""``make kill-matrix``: every process that may die is killed, stopped or ended, in every state, for real."""

from __future__ import annotations

import argparse
import json
import queue
import shutil
import signal
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp

from rich.console import Console

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_lab.demo import Ros1, Ros2
from tests.acceptance.kill_matrix.cells import PROCESSES, Cell, chosen, full, gripping, telling
from tests.acceptance.kill_matrix.play import Play, Row
from tests.acceptance.kill_matrix.system import System
from tests.acceptance.kill_matrix.system_plain import PlainSystem
from tests.acceptance.kill_matrix.system_ros1 import Ros1System
from tests.acceptance.kill_matrix.system_ros2 import FIVE, ONE, Ros2System
from tests.acceptance.kill_matrix.table import show
from tests.acceptance.kill_matrix.waiting import Late, Stopped, stopping

console = Console(width=190, highlight=False)


def main() -> int:
    arguments = _arguments()
    try:
        description, cells = _asked(arguments)
    except ReportedError as error:
        Console(stderr=True, highlight=False, soft_wrap=True).print(error, markup=False)
        return error.exit_code
    if arguments.list:
        console.print("\n".join(map(str, cells)))
        return 0
    try:
        if arguments.ros != "none":
            (Ros1() if arguments.ros == "1" else Ros2()).check()
    except ReportedError as error:
        console.print(str(error))
        return 3
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, lambda *_: stopping.set())
    begun, folder = time.monotonic(), Path(mkdtemp(prefix="eehal-kill-"))
    rows = Matrix(description, cells, folder, arguments.systems, arguments.ros, arguments.part).run()
    rows.sort(key=lambda row: cells.index(row.cell))
    show(console, rows)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(
        json.dumps([row.as_json() for row in rows], indent=1) + "\n", encoding="utf-8"
    )
    hold = sum(row.ok for row in rows)
    twice = sum(row.ok and bool(row.before) for row in rows)
    text = f"{hold} of {len(cells)} cells hold{f' ({twice} at the second play)' if twice else ''}"
    text += f", {time.monotonic() - begun:.0f} s; {arguments.output}"
    if hold == len(cells):
        shutil.rmtree(folder, ignore_errors=True)
    else:
        text += f"; logs: {folder}"
    console.print(text)
    return int(hold != len(cells))


class Matrix:
    """Plays cells on some systems at once; a system in which a cell does not hold is not used any more.

    Such a cell is played once more, for these are processes on a shared machine; the row keeps what came before.
    """

    def __init__(
        self,
        description: Description,
        cells: list[Cell],
        folder: Path,
        systems: int,
        generation: str,
        part: str = "",
    ) -> None:
        self._description, self._folder, self._total = description, folder, len(cells)
        self._generation, self._part = generation, part
        self._left: queue.SimpleQueue[Cell] = queue.SimpleQueue()
        # those that take longest first
        for cell in sorted(cells, key=lambda cell: (cell.process != "roscore", cell.state)):
            self._left.put(cell)
        self._rows: list[Row] = []
        self._threads = [
            threading.Thread(target=self._work, args=(i,)) for i in range(min(systems, len(cells)))
        ]

    def run(self) -> list[Row]:
        """All rows that came to an end."""
        for thread in self._threads:
            thread.start()
        for thread in self._threads:
            while thread.is_alive():
                thread.join(0.2)  # signals are handled between
        return self._rows

    def _work(self, number: int) -> None:
        count = 0
        again: tuple[Cell, str] | None = None
        try:
            while again or not self._left.empty():
                count += 1
                with self._system(self._folder / f"{number}-{count}") as system:
                    again = self._play(system, again)
        except Stopped:
            return
        except (ReportedError, Late) as error:
            console.print(f"system {number} cannot be started: {error}", style="red")

    def _system(self, folder: Path) -> System:
        if self._generation == "none":
            return PlainSystem(folder, self._description, self._part)
        if self._generation == "1":
            return Ros1System(folder, self._description)
        return Ros2System(folder, self._description, FIVE if self._generation == "2-five" else ONE)

    def _play(self, system: System, again: tuple[Cell, str] | None) -> tuple[Cell, str] | None:
        """Cells, one after the other; ends when one does not hold. It is returned, once, with what was observed."""
        cell, before = again or (self._next(), "")
        while cell:
            begun = time.monotonic()
            play = Play(system, cell)
            try:
                row = play.run()
            except (Late, ReportedError) as error:
                wanted = play.expected.text(play.names)
                row = Row(cell, wanted, f"could not be played: {error}", False, time.monotonic() - begun)
            if not row.ok and not before:
                console.print(f"        again  {cell}: {row.observed}")
                return cell, row.observed
            self._rows.append(replace(row, before=before))
            mark = "ok  " if row.ok else "FAIL"
            console.print(
                f"{len(self._rows):3}/{self._total} {mark} {row.seconds:5.1f} s  {cell}: {row.observed}"
            )
            if not row.ok:
                return None
            cell, before = self._next(), ""
        return None

    def _next(self) -> Cell | None:
        try:
            return self._left.get_nowait()
        except queue.Empty:
            return None


def _asked(arguments: argparse.Namespace) -> tuple[Description, list[Cell]]:
    """The tool, and its cells that are to be played; raises ReportedError."""
    whole = description = load_tool(arguments.description)
    if description.tool_changer is None and arguments.ros != "none":
        raise UsageError(
            "The matrix hears the node Position by the place of the tool changer: it takes a tool with a tool changer.",
            where=str(arguments.description),
        )
    if arguments.part and (arguments.part not in description.parts or arguments.ros != "none"):
        raise UsageError(
            f"--part {arguments.part}: it takes --ros none, and a part of the tool.",
            todo=f"There are: {', '.join(description.parts) or 'none'}.",
        )
    description = gripping(description, arguments.part)
    if not arguments.cells:
        some = full if arguments.full else telling
        return whole, list(some(description, arguments.ros))
    cells = chosen(arguments.cells, description, arguments.ros)
    if not cells:
        raise UsageError(f"No cell is {' or '.join(arguments.cells)}.", todo="--list --full names them all.")
    return whole, cells


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--ros", choices=PROCESSES, default="1", help="1, 2 with five processes or one, or none (default 1)"
    )
    parser.add_argument("--full", action="store_true", help="all cells")
    parser.add_argument(
        "--description",
        type=Path,
        default=profile_path(),
        metavar="FILE",
        help="another tool, with other endings (default: the shipped one)",
    )
    parser.add_argument(
        "--part",
        default="",
        metavar="NAME",
        help="the part that is gripped, with --ros none (default: the first)",
    )
    parser.add_argument("--systems", type=int, default=2, metavar="N", help="systems at once (default 2)")
    parser.add_argument("--list", action="store_true", help="list the cells, play none")
    parser.add_argument("-o", "--output", type=Path, default=None, metavar="FILE")
    parser.add_argument(
        "cells", nargs="*", metavar="PROCESS:SIGNAL:STATE", help="only these; parts may be cut off"
    )
    arguments = parser.parse_args()
    if arguments.output is None:
        arguments.output = Path(
            f"runs/kill-matrix{'' if arguments.ros == '1' else f'-ros{arguments.ros}'}.json"
        )
    return arguments


if __name__ == "__main__":
    sys.exit(main())
