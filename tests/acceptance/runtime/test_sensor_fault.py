"""A sensor fault of the tool changer stays latched through the death of its program: the line arbiter keeps it."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.arbiter.records import Journal
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.control import Status
from end_effector_hal.runtime import Program, open_program
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerFault, ChangerState
from end_effector_hal.wires import now_us
from end_effector_lab.demo._world import World
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]
SLOW_DISK = """
import sys, time
from pathlib import Path
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.description import load
from end_effector_hal.arbiter import ArbiterServer, arbiter_policy
from end_effector_hal.wires.lines import VirtualLines
description, chip, socket, journal, answers = sys.argv[1:]

class Slow(FileStorage):
    def read(self):
        while self._durable and not Path(answers).exists():
            time.sleep(0.05)
        return super().read()

import end_effector_hal.arbiter.server._server as server
server.FileStorage = Slow
with ArbiterServer(VirtualLines(chip), socket, arbiter_policy(load(description)), journal) as arbiter:
    arbiter.serve()
"""
"""The line arbiter, on a disk that gives nothing back before the file ``answers`` is there."""
PRESSURES = {"bottom": 0.0, "cylinder": 0.0, "top": 0.0, "supply": 600_000.0}


def fed(program: Program, until: Callable[[Status], bool], *, unlocked: bool) -> Status:
    """Frames of a locked tool, whose other bit is as given, until a status is as wanted."""
    end = time.monotonic() + PATIENCE_S
    while not until(program.status):
        assert time.monotonic() < end, program.status
        bits = {"locked": True, "unlocked": unlocked, "tool_present": True}
        program.frame(Frame(now_us(), None, None, {**PRESSURES, **bits}))
        time.sleep(0.02)
    return program.status


def faults(world: World) -> set[str]:
    with ArbiterClient(world.socket, "look") as look:
        return set(look.status()["faults"])


def test_a_sensor_fault_is_there_again_after_a_restart_until_a_reset(world: World) -> None:
    first = open_program(world.description)
    first.start()
    fed(first, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
    assert not faults(world)
    status = fed(first, lambda status: status.changer == ChangerState.FAULT, unlocked=True)
    assert status.changer_fault == ChangerFault.SENSOR
    assert faults(world) == {"sensor_fault"}
    first.close()

    second = open_program(world.description)
    second.start()
    status = fed(second, lambda status: status.changer != ChangerState.UNKNOWN, unlocked=False)
    assert (status.changer, status.changer_fault) == (ChangerState.FAULT, ChangerFault.SENSOR)
    fed(second, lambda status: "sensor fault" in " ".join(status.alarm_texts), unlocked=False)
    with ArbiterClient(world.socket, "reset") as arbiter:
        assert arbiter.reset() == {"sensor_fault": "hal has latched sensor_fault, and has not been reset."}
    assert faults(world) == {"sensor_fault"}
    assert second.command("reset").accepted
    assert not faults(world), "the program has cleared it before it answers"
    fed(second, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
    assert not faults(world)
    second.close()

    third = open_program(world.description)
    third.start()
    fed(third, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
    third.close()


def test_a_fault_that_a_slow_disk_gives_back_late_is_there_until_its_program_is_reset(
    world: World, tmp_path: Path
) -> None:
    world.arbiter.end(signal_number=signal.SIGKILL)
    for left in world.place.glob("arbiter.sock*"):
        left.unlink()  # what a loss of power leaves: the journal alone
    entry = Journal(FileStorage(tmp_path / "journal", durable=True), "the boot before", now_us)
    entry.keep({"sensor_fault": "IL-04: of the boot before."})
    assert entry.write_next()
    entry.close()
    answers = tmp_path / "answers"
    given = (world.description_path, world.chip, world.socket, tmp_path / "journal", answers)
    arbiter = subprocess.Popen([sys.executable, "-c", SLOW_DISK, *map(str, given)])
    try:
        wait_until("its socket", world.socket.exists)
        program = open_program(world.description)
        program.start()
        fed(program, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
        assert faults(world) == {"journal"}
        answers.touch()
        wait_until("the fault", lambda: "sensor_fault" in faults(world))
        with ArbiterClient(world.socket, "reset") as client:
            assert client.reset() == {"sensor_fault": "hal has latched sensor_fault, and has not been reset."}
        status = fed(program, lambda status: status.changer == ChangerState.FAULT, unlocked=False)
        assert status.changer_fault == ChangerFault.SENSOR
        assert program.command("reset").accepted
        assert not faults(world)
        fed(program, lambda status: status.changer == ChangerState.LOCKED, unlocked=False)
        program.close()
    finally:
        arbiter.terminate()
        arbiter.wait(PATIENCE_S)
