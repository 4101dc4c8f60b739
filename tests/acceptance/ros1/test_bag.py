"""A bag of ``rosbag record`` becomes the recording that DataLogger wrote of the same run."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import read_pressures, read_run, read_states
from end_effector_lab.bags import Bag, import_bag
from tests.support.nightly import first_of

pytestmark = pytest.mark.ros
TOPICS = ("/EndEffectorState", "/PressureVacuumBottom", "/PressureCylinder")


def timed(folder: Path) -> list[tuple[int, Any]]:
    """Rows of the states, with µs on the monotonic clock."""
    start_us = read_run(folder).start_us
    assert start_us is not None
    log = read_states(folder / "states.csv")
    return [(start_us + round(row.time_s * 1e6), row.states) for row in log.rows]


@pytest.mark.parametrize("compression", first_of(["--lz4", "--bz2"]))
def test_a_grip_is_imported_as_it_was_recorded(system: Any, tmp_path: Path, compression: str) -> None:
    logged, bag = tmp_path / "logged", tmp_path / "run.bag"
    logger = system.start(
        "logger_bag", "rosrun", "end_effector_hal", "data_logger", "__name:=logger_bag",
        f"_description:={system.world.description_path}", f"_directory:={logged}",
    )  # fmt: skip
    recorder = system.start(
        "record_bag", "rosrun", "rosbag", "record", "__name:=record_bag", compression, "-O", str(bag), *TOPICS,
        end_by=signal.SIGINT, patience_s=20.0,
    )  # fmt: skip

    def connected() -> bool:
        """Whether both are known as subscribers, and the logger has its first rows."""
        import rosgraph

        subscribers = dict(rosgraph.Master("/tests").getSystemState()[1])
        begun = (logged / "alarms.csv").exists() and read_states(logged / "states.csv").rows
        recorded = all("/record_bag" in subscribers.get(topic, ()) for topic in TOPICS)
        return bool(begun) and recorded and "/logger_bag" in subscribers[TOPICS[0]]

    def heard() -> None:
        """Both have what the test has: 0.5 s later nothing of it is under way."""
        seen = len(system.states)
        system.until("more states", lambda: len(system.states) > seen + 5)

    system.until("both subscribe", connected)
    heard()
    system.rest()  # what starts takes the sensors their time
    system.grip()
    heard()
    recorder.end()
    logger.end()
    with closing(Bag(bag)) as opened:
        found = import_bag(opened, tmp_path / "imported", description=system.world.description)
    assert not found.faults
    ours, theirs = timed(found.folder), timed(logged)
    assert len(ours) > 6
    assert ours[1:] == theirs[1:]
    assert ours[0][1] == theirs[0][1]
    pressures = read_pressures(found.folder / "pressures.csv")
    assert min(value for value in pressures.curve("bottom") if value is not None) < -55


def test_a_recorder_that_was_killed(system: Any, tmp_path: Path) -> None:
    """Its file has no index, and is called ``.active``; `rosbag reindex` repairs it."""
    recorder = system.start(
        "killed_bag", "rosrun", "rosbag", "record", "__name:=killed_bag", "--chunksize=4", "-O",
        str(tmp_path / "run.bag"), *TOPICS,
    )  # fmt: skip
    bag = tmp_path / "run.bag.active"
    system.until("chunks", lambda: bag.exists() and bag.stat().st_size > 50_000)
    os.kill(recorder.pid, signal.SIGKILL)
    system.until("its end", lambda: recorder.code is not None)
    with pytest.raises(UsageError, match=r"is damaged.*`rosbag reindex`"):
        Bag(bag)
    reindexed = system.start("reindexed_bag", "rosbag", "reindex", str(bag))
    system.until("its index", lambda: reindexed.code is not None)
    with closing(Bag(bag)) as opened:
        found = import_bag(opened, tmp_path / "imported", description=system.world.description)
    assert found.states > 10
    assert found.pressures > 50
    assert read_states(found.folder / "states.csv").rows
