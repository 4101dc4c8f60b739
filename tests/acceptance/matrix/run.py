"""``make matrix-processes``: some cells of ``eehal matrix`` on real processes; each must end as is allowed."""

from __future__ import annotations

import argparse
import json
import queue
import shutil
import signal
import sys
import threading
import time
from pathlib import Path
from tempfile import mkdtemp

from rich.console import Console

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_lab.matrix import Cell, Moment
from tests.acceptance.kill_matrix.prepare import at_rest
from tests.acceptance.kill_matrix.system_plain import PlainSystem
from tests.acceptance.kill_matrix.waiting import Late, Stopped, stopping
from tests.acceptance.matrix.play import RealCell, Row
from tests.acceptance.matrix.sample import playable, sample

console = Console(width=190, highlight=False)


class Sample:
    """Plays cells on some systems at once; a system in which a cell does not end as is allowed is not used again."""

    def __init__(
        self, description: Description, cells: list[tuple[Cell, Moment | None]], folder: Path, systems: int
    ) -> None:
        self._description, self._folder, self._total = description, folder, len(cells)
        self._left: queue.SimpleQueue[tuple[Cell, Moment | None]] = queue.SimpleQueue()
        for each in cells:
            self._left.put(each)
        self._again: set[Cell] = set()
        self.rows: list[Row] = []
        self._threads = [
            threading.Thread(target=self._work, args=(number,)) for number in range(min(systems, len(cells)))
        ]

    def run(self) -> None:
        """Until all were played."""
        for thread in self._threads:
            thread.start()
        for thread in self._threads:
            while thread.is_alive():
                thread.join(0.2)  # signals are handled between

    def _work(self, number: int) -> None:
        count = 0
        try:
            while not self._left.empty():
                count += 1
                with PlainSystem(self._folder / f"{number}-{count}", self._description) as system:
                    while self._play(system):
                        pass
        except Stopped:
            return
        except (ReportedError, Late) as error:
            console.print(f"system {number} cannot be started: {error}", style="red")

    def _play(self, system: PlainSystem) -> bool:
        """Whether this system can be used further."""
        try:
            cell, event = self._left.get_nowait()
        except queue.Empty:
            return False
        try:
            at_rest(system)
        except Late as late:  # what an earlier cell has left: not of this one
            if cell in self._again:
                self.rows.append(Row(cell, "", "", 0.0, (f"could not be begun: {late}",)))
            else:
                self._again.add(cell)
                self._left.put((cell, event))
            return False
        try:
            row = RealCell(system, cell, event).run()
        except (Late, ReportedError) as error:
            row = Row(cell, "", "", 0.0, (f"could not be played: {error}",))
        self.rows.append(row)
        mark = "FAIL" if row.faults else "same" if row.same else "ok  "
        told = row.real if row.same else f"{row.real} (virtual: {row.virtual})"
        console.print(
            f"{len(self.rows):3}/{self._total} {mark} {row.seconds:5.1f} s  {cell.id}: "
            f"{'. '.join([told, *row.faults])}",
            markup=False,
        )
        return not row.faults


def main() -> int:
    arguments = _arguments()
    try:
        description = load_tool(arguments.description)
        cells = sample(description, arguments.sample, arguments.seed)
        if arguments.cell:
            cells = [(cell, event) for cell, event in playable(description) if arguments.cell in cell.id]
    except ReportedError as error:
        Console(stderr=True, highlight=False, soft_wrap=True).print(error, markup=False)
        return error.exit_code
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, lambda *_: stopping.set())
    begun, folder = time.monotonic(), Path(mkdtemp(prefix="eehal-matrix-"))
    played = Sample(description, cells, folder, arguments.systems)
    played.run()
    rows = played.rows
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps([_json(row) for row in rows], indent=1) + "\n", encoding="utf-8")
    allowed, same = sum(not row.faults for row in rows), sum(row.same for row in rows)
    console.print(
        f"{allowed} of {len(cells)} cells end as is allowed, {same} as in virtual time; "
        f"{time.monotonic() - begun:.0f} s; {arguments.output}"
    )
    if allowed == len(cells):
        shutil.rmtree(folder, ignore_errors=True)
    else:
        console.print(f"logs: {folder}")
    return int(allowed != len(cells))


def _json(row: Row) -> dict[str, object]:
    return {
        "id": row.cell.id, "virtual": row.virtual, "real": row.real, "same": row.same,
        "seconds": round(row.seconds, 1), "faults": row.faults,
    }  # fmt: skip


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, default=50, metavar="N", help="cells (default 50)")
    parser.add_argument("--seed", type=int, default=0, help="of the choice (default 0)")
    parser.add_argument("--cell", default="", metavar="TEXT", help="the cells whose id has this text")
    parser.add_argument("--systems", type=int, default=3, metavar="N", help="systems at once (default 3)")
    parser.add_argument(
        "--description", type=Path, default=profile_path(), metavar="FILE", help="another tool"
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("runs/matrix-processes.json"), metavar="FILE"
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
