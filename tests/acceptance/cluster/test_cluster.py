"""A scheduler and its workers as real processes: every item once, whoever dies, and what does not fit is refused."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import Client

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import WorkersError
from end_effector_lab.processes import EEHAL
from end_effector_lab.trials import Campaign, cells_of, moments, play_all, run_campaign
from end_effector_lab.workers import LocalWorkers, Workers, _cluster
from tests.support.nightly import NIGHTLY
from tests.support.patience import wait_until

from . import functions
from .conftest import ENV, Cluster

pytestmark = pytest.mark.wall
at_length = pytest.mark.skipif(not NIGHTLY, reason="takes half a minute: make nightly")
SHIPPED = load(profile_path())


@pytest.fixture
def workers(cluster: Cluster) -> Iterator[Workers]:
    with Client(cluster.address, set_as_default=False) as client:
        client.wait_for_workers(3, timeout=60)
    with _cluster.ClusterWorkers(cluster.address) as opened:
        yield opened


def pids(address: str) -> dict[str, int]:
    with Client(address, set_as_default=False) as client:
        return dict(client.run(os.getpid))


def test_every_item_comes_once_with_its_result(workers: Workers) -> None:
    found = list(workers.each(functions.add, 1000, range(300)))
    assert sorted(found) == [(item, item + 1000) for item in range(300)]
    assert list(workers.each(functions.add, 1, [1])) == [(1, 2)]  # nothing is left of the one before


def test_the_cells_of_a_worker_that_is_killed_are_played_by_others(
    workers: Workers, cluster: Cluster, tmp_path: Path
) -> None:
    cells = [*cells_of(SHIPPED, moments(SHIPPED))][3::1500]
    victim, killed = next(iter(pids(cluster.address).values())), []

    def on_progress(done: int, of: int) -> None:
        if done and not killed and done < of - 6:
            os.kill(victim, signal.SIGKILL)
            killed.append(done)

    kept = tmp_path / "cells.jsonl"
    found = play_all(SHIPPED, cells, workers=workers, lines=kept, on_progress=on_progress)
    assert killed
    lines = kept.read_text().splitlines()
    assert sorted(json.loads(line)["id"] for line in lines) == sorted(cell.id for cell in cells)
    with LocalWorkers(2) as local:
        here = play_all(SHIPPED, cells, workers=local)
    assert found == here


@pytest.mark.thinned  # long
def test_a_campaign_is_the_same_on_any_workers(workers: Workers, tmp_path: Path) -> None:
    def go_on(_: Campaign, run: int) -> bool:
        return (
            run < 24
        )  # more than are under way at once: later runs are drawn from what the first ones reached

    with LocalWorkers(1) as local:
        here = run_campaign(SHIPPED, tmp_path / "local", local, seed=4, go_on=go_on)
    there = run_campaign(SHIPPED, tmp_path / "cluster", workers, seed=4, go_on=go_on)
    assert there.runs == here.runs == 24
    assert there.reached.edges == here.reached.edges
    runs = [(tmp_path / name / "runs.jsonl").read_text() for name in ("local", "cluster")]
    assert runs[0] == runs[1]


def test_an_item_that_kills_is_named_after_all_others_are_done(workers: Workers) -> None:
    found: list[int] = []

    def collect() -> None:
        for item, _ in workers.each(functions.die, 7, range(20)):
            found.append(item)

    with pytest.raises(WorkersError, match=r"1 item is not done because the workers died: 7\."):
        collect()
    assert sorted(found) == [item for item in range(20) if item != 7]


def test_what_a_function_raises_is_raised_here(workers: Workers) -> None:
    with pytest.raises(ValueError, match="no 5"):
        list(workers.each(functions.fail, None, [5]))


def test_a_worker_of_another_version_is_named(
    workers: Workers, cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_cluster, "identity", lambda: {"end-effector-hal": "9.9"})
    with pytest.raises(WorkersError, match=r"end-effector-hal is .* there, 9\.9 here") as caught:
        list(workers.each(functions.add, 1, [1]))
    assert caught.value.where in pids(cluster.address)
    monkeypatch.setattr(_cluster, "_CHECKED", ("python", "a-package-of-this-side"))
    ours = _cluster._versions

    def here(found: dict[str, dict[str, str]]) -> dict[str, str]:
        return ours(found) | ({"a-package-of-this-side": "2"} if "host" in found and not seen else {})

    seen: list[int] = []
    monkeypatch.setattr(_cluster, "_versions", lambda found: [here(found), seen.append(1)][0])
    with pytest.raises(WorkersError, match="a-package-of-this-side is missing there, 2 here"):
        _cluster.ClusterWorkers(cluster.address).__enter__()


def test_what_a_worker_cannot_read_is_no_traceback(workers: Workers) -> None:
    with pytest.raises(WorkersError, match=r"cannot read what it was sent .*eehal_not_there"):
        list(workers.each(functions.add, functions.NotThere(), [1]))  # type: ignore[misc]


def test_a_scheduler_that_dies_leaves_what_was_done(bare: Cluster, tmp_path: Path) -> None:
    bare.worker("--nthreads", "1", "--no-nanny")
    found = []

    def collect(workers: Workers) -> None:
        for item, _ in workers.each(functions.slow, tmp_path, range(10_000)):
            found.append(item)
            if len(found) == 1:
                bare.scheduler.end(signal_number=signal.SIGKILL)

    with (
        _cluster.ClusterWorkers(bare.address) as opened,
        pytest.raises(WorkersError, match="The scheduler has gone"),
    ):
        collect(opened)
    assert found
    assert len(list(tmp_path.iterdir())) < 1000  # few were in front of the worker


@at_length
def test_what_is_no_worker_is_not_waited_for(
    bare: Cluster, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(_cluster, "JOIN_S", 0.5)
    with pytest.raises(WorkersError, match="has no worker"):
        _cluster.ClusterWorkers(bare.address).__enter__()
    monkeypatch.setattr(_cluster, "JOIN_S", 30)
    monkeypatch.setattr(_cluster, "GONE_S", 0.5)
    worker = bare.worker("--nthreads", "2", "--no-nanny")
    with (
        _cluster.ClusterWorkers(bare.address) as opened,
        pytest.raises(WorkersError, match="it has 2 threads"),
    ):
        list(opened.each(functions.add, 1, [1]))
    worker.end()
    worker = bare.worker("--nthreads", "1", "--no-nanny")

    def collect(workers: Workers) -> None:
        for _ in workers.each(functions.slow, tmp_path, range(10_000)):
            worker.end(signal_number=signal.SIGKILL)

    with (
        _cluster.ClusterWorkers(bare.address) as opened,
        pytest.raises(WorkersError, match="All workers have gone"),
    ):
        collect(opened)


def matrix(folder: Path, *arguments: str) -> list[str]:
    return [*EEHAL, "matrix", "--only", "nominal @ grip", "-o", str(folder), "--json", *arguments]


@at_length
def test_ctrl_c_leaves_whole_lines(workers: Workers, cluster: Cluster, tmp_path: Path) -> None:
    env, kept = {**os.environ, **ENV}, tmp_path / "cells.jsonl"
    command = matrix(tmp_path, "--every", "9", "--scheduler", cluster.address)
    begun = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    wait_until("some cells", lambda: kept.exists() and kept.read_text().count("\n") >= 2)
    begun.send_signal(signal.SIGINT)
    _, said = begun.communicate(timeout=60)
    assert (begun.returncode, said.strip()) == (130, b"")
    assert all(json.loads(line)["id"] for line in kept.read_text().splitlines())


def test_an_address_where_nobody_listens_is_one_sentence(tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        begun = time.monotonic()
        result = subprocess.run(
            matrix(tmp_path, "--scheduler", address),
            env={**os.environ, **ENV},
            capture_output=True,
            text=True,
        )
    assert result.returncode == 3
    assert "The scheduler cannot be reached" in json.loads(result.stdout)["faults"][0]["message"]
    assert result.stderr == ""
    assert time.monotonic() - begun < 60
