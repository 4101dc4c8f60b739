"""A bag that a live subscriber wrote becomes the recording that DataLogger wrote of the same run."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

from end_effector_hal.errors import RosError
from end_effector_hal.recording import StatesLog, read_pressures, read_run, read_states, read_story
from end_effector_lab.bags import Bag, import_bag


def timed(folder: Path) -> list[tuple[int, Any]]:
    """Rows of the states, with µs on the monotonic clock."""
    start_us = read_run(folder).start_us
    assert start_us is not None
    log: StatesLog = read_states(folder / "states.csv")
    return [(start_us + round(row.time_s * 1e6), row.states) for row in log.rows]


def test_a_grip_and_a_drop_are_imported_as_they_were_recorded(system: Any, tmp_path: Path) -> None:
    logged, bag = tmp_path / "logged", tmp_path / "bag"
    logger = system.start("data_logger", "-p", f"directory:={logged}")
    recorder = system.world.children.start(
        "record_bag", [sys.executable, "-m", "tests.acceptance.ros2.record_bag", str(bag)],
        log=tmp_path / "record_bag.log", failed=RosError, env=system.env, end_by=signal.SIGINT, patience_s=20.0,
    )  # fmt: skip

    def both_have_it() -> bool:
        heard = (tmp_path / "record_bag.log").read_text().split()
        rows = read_states(logged / "states.csv").rows if (logged / "alarms.csv").exists() else ()
        state = system.state
        now = (state.state, state.command, *state.actuators)
        return bool(rows and heard) and rows[-1].states == now and heard[-1] == str(state.count)

    system.until("the first state", both_have_it)
    system.put_down()  # what starts takes the sensors their time
    system.do("TriggerGrip")
    system.do("Drop")
    system.until("the last state", both_have_it)
    for child in (recorder, logger):
        os.kill(child.pid, signal.SIGINT)
        system.until("its end", lambda child=child: child.code is not None)

    with closing(Bag(bag)) as opened:
        found = import_bag(opened, tmp_path / "imported", description=system.world.description)
    assert not found.faults
    assert read_run(found.folder).gaps == ()
    ours, theirs = timed(found.folder), timed(logged)
    assert len(ours) > 12
    assert ours[0][1] == theirs[0][1]  # which stands at the beginning of each
    assert ours[1:] == theirs[1:]
    attempts, logged_attempts = (
        read_story(read_states(each / "states.csv")).attempts for each in (found.folder, logged)
    )
    assert [str(each) for each in attempts] == [str(each) for each in logged_attempts]
    assert len(attempts) == len(system.state.actuator_names)
    pressures = read_pressures(found.folder / "pressures.csv")
    assert pressures.channels == read_pressures(logged / "pressures.csv").channels
    assert min(value for value in pressures.curve("bottom") if value is not None) < -55
