"""The cost of a cell on a dask.distributed cluster: one and two workers on one scheduler, and the scheduler's share.

Run by hand, from the folder of the project: ``python benchmarks/cluster.py``. Times are CPU times of the processes: on
an idle machine, the elapsed time is the same.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

from distributed import Client

from end_effector_hal.description import Description, load, profile_path
from end_effector_lab.processes import Child, Children
from end_effector_lab.trials import Cell, cells_of, moments, play_all, thinned
from end_effector_lab.workers import open_workers

DASK = (sys.executable, "-m", "dask")
HOST = ("--host", "127.0.0.1", "--no-dashboard")
START_S = 60.0
NOTHING = 20_000


def main() -> None:
    """Print the results as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=150, help="play one cell of N of the shipped tool")
    every = parser.parse_args().every
    description = load(profile_path())
    cells = thinned([*cells_of(description, moments(description))], every)
    with tempfile.TemporaryDirectory() as name, Children() as children:
        folder = Path(name)
        begun = time.process_time()
        with open_workers(None, 1) as here:
            play_all(description, cells, workers=here)
        found: dict[str, object] = {"cells": len(cells), "here_s": time.process_time() - begun}
        scheduler, address = _scheduler(children, folder)
        for count in (1, 2):
            children.start(
                "worker",
                [*DASK, "worker", address, "--nthreads", "1", "--no-nanny", *HOST],
                log=folder / f"worker-{count}.log",
            )
            with Client(address, set_as_default=False) as client:
                client.wait_for_workers(count, timeout=START_S)
                _play(description, cells[:20], address)
                found[f"workers_{count}"] = _measured(client, scheduler, description, cells, address)
        with Client(address, set_as_default=False) as client:
            found["scheduler_of_nothing"] = _of_nothing(client, scheduler, address)
    print(json.dumps(found | _ratios(found), indent=1))


def _scheduler(children: Children, folder: Path) -> tuple[Child, str]:
    file = folder / "scheduler.json"
    scheduler = children.start(
        "scheduler",
        [*DASK, "scheduler", "--port", "0", "--scheduler-file", str(file), *HOST],
        log=folder / "scheduler.log",
    )
    scheduler.wait_until(file.exists, timeout_s=START_S, what="its file")
    time.sleep(0.5)
    return scheduler, json.loads(file.read_text())["address"]


def _play(description: Description, cells: list[Cell], address: str) -> None:
    with open_workers(address, None) as workers:
        play_all(description, cells, workers=workers)


def _measured(
    client: Client, scheduler: Child, description: Description, cells: list[Cell], address: str
) -> dict[str, object]:
    def used() -> tuple[dict[str, float], float, float]:
        return client.run(time.process_time), _cpu_s(scheduler.pid), time.process_time()

    before, wall = used(), time.monotonic()
    _play(description, cells, address)
    wall, after = time.monotonic() - wall, used()
    return {
        "workers_s": [round(after[0][each] - before[0][each], 2) for each in after[0]],
        "scheduler_s": round(after[1] - before[1], 2),
        "client_s": round(after[2] - before[2], 2),
        "wall_s": round(wall, 1),
    }


def _of_nothing(client: Client, scheduler: Child, address: str) -> dict[str, float]:
    """Measure items that cost nothing, so that all of the time is the overhead of the distribution."""
    before = _cpu_s(scheduler.pid), time.process_time()
    with open_workers(address, None) as workers:
        tasks = sum(1 for _ in workers.each(max, 0, range(1, NOTHING + 1)))
    after = _cpu_s(scheduler.pid), time.process_time()
    assert tasks == NOTHING
    return {
        "scheduler_ms_per_item": round((after[0] - before[0]) / NOTHING * 1e3, 4),
        "client_ms_per_item": round((after[1] - before[1]) / NOTHING * 1e3, 4),
    }


def _ratios(found: dict[str, object]) -> dict[str, float]:
    cells, one, two = found["cells"], found["workers_1"], found["workers_2"]
    assert isinstance(cells, int)
    assert isinstance(one, dict)
    assert isinstance(two, dict)
    here = found["here_s"]
    assert isinstance(here, float)
    return {
        "cells_per_core_second": round(cells / sum(two["workers_s"]), 2),
        "cells_per_core_second_here": round(cells / here, 2),
        "cells_per_core_hour": round(3600 * cells / sum(two["workers_s"])),
        "speed_of_two_over_one_wall": round(one["wall_s"] / two["wall_s"], 2),
        "speed_of_two_on_processors_of_their_own": round(sum(two["workers_s"]) / max(two["workers_s"]), 2),
        "scheduler_ms_per_cell": round(two["scheduler_s"] / cells * 1e3, 2),
        "client_ms_per_cell": round(two["client_s"] / cells * 1e3, 2),
    }


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
