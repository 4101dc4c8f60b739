"""``eehal run --record`` on a disk that fills while it grips and while it holds: a real tmpfs, a real process."""

from __future__ import annotations

import json
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.recording import read_run, read_states
from end_effector_hal.verification.replay import load_trace, traces_of
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.small_disk import SmallDisk, small_disk

pytestmark = [pytest.mark.wall, pytest.mark.timeout(240)]


class Run:
    """The command, with a person at its prompt."""

    def __init__(self, world: World, folder: Path) -> None:
        self.folder = folder
        command = [*EEHAL, "run", str(world.description_path), "--json", "--record", str(folder)]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        self.told: list[dict[str, Any]] = []
        self.refused = 0
        """Commands: one that failed is told by the exit code."""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.told.append(json.loads(line))

    def type(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def wait(self, what: str, **content: Any) -> dict[str, Any]:
        """The first line that says this."""

        def found() -> dict[str, Any] | None:
            fitting = (each for each in self.told if content.items() <= each.items())
            return next(fitting, None)

        try:
            return wait_until(what, found)
        except AssertionError as error:
            raise AssertionError(f"{error}; told was {self.told}") from None

    def do(self, command: str, name: str) -> None:
        """A command, again where a busy machine has had it refused."""

        def succeeds() -> bool:
            self.told.clear()
            self.type(command)
            return self._counted(bool(self.wait(name, event="result", command=name)["succeeded"]))

        wait_until(f"{name} succeeds", succeeds)

    def _counted(self, accepted: bool) -> bool:
        self.refused += not accepted
        return accepted

    def begin_grip(self) -> None:
        """A grip that is accepted."""

        def accepted() -> bool:
            self.told.clear()
            self.type("grip")
            return self._counted(wait_until("an answer", self._grip_answered)["event"] == "state")

        wait_until("a grip is accepted", accepted)

    def _grip_answered(self) -> dict[str, Any] | None:
        answers = (
            each
            for each in list(self.told)
            if each.get("end_effector") == "GRIPPING" or each["event"] == "result"
        )
        return next(answers, None)

    def alarms(self, *, over: bool) -> str:
        return " ".join(
            each["text"] for each in self.told if each["event"] == "alarm" and each["over"] is over
        )

    def end(self) -> int:
        if self.process.poll() is None:
            self.process.kill()
        code = self.process.wait(PATIENCE_S)
        self._reader.join(PATIENCE_S)
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            pipe.close()
        return code


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[SmallDisk]:
    with small_disk(tmp_path / "disk") as made:
        yield made


def quick() -> Description:
    """The shipped tool, whose top vacuum fails earlier."""
    tool = load(profile_path())
    short = tool.actuators["top_vacuum"].model_copy(update={"timeout_s": 2.0})
    return tool.model_copy(update={"actuators": {**tool.actuators, "top_vacuum": short}})


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with World(quick(), "fails-once:top_vacuum", tmp_path) as running:
        yield running


@pytest.fixture
def run(world: World, disk: SmallDisk) -> Iterator[Run]:
    running = Run(world, disk.path / "run")
    yield running
    running.end()


def eehal(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [*EEHAL, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def grips_on_a_full_disk(run: Run, disk: SmallDisk) -> None:
    run.begin_grip()  # the first attempt of the top vacuum fails: there is time
    disk.fill()
    wait_until("an alarm of the trace", lambda: "The trace is not recorded" in run.alarms(over=False))
    wait_until(
        "an alarm of the rows", lambda: "Rows of the recording cannot be written" in run.alarms(over=False)
    )
    result = run.wait("GRIP", event="result", command="GRIP")
    assert result["succeeded"], result


def test_what_fills_while_gripping_and_while_gripped_drops_nothing_and_ends_nothing(
    run: Run, disk: SmallDisk
) -> None:
    run.do("lock", "LOCK")
    grips_on_a_full_disk(run, disk)
    run.told.clear()
    disk.free()
    wait_until("it is recorded again", lambda: "The trace is not" in run.alarms(over=True))
    wait_until("rows are, too", lambda: "The listener that records failed" in run.alarms(over=True))
    run.do("drop", "RELEASE")
    run.do("reset", "RESET")
    run.do("grip", "GRIP")
    run.wait("held", event="state", end_effector="GRIPPED")
    disk.fill()
    wait_until("an alarm of the trace", lambda: "The trace is not recorded" in run.alarms(over=False))
    run.do("drop", "RELEASE")
    run.type("quit")
    assert run.process.wait(PATIENCE_S) == bool(run.refused)
    disk.free()

    # what was recorded is there, and says what is not
    traces = [load_trace(path) for path in traces_of(run.folder) if path.name.startswith("hal")]
    assert [trace.header.segment for trace in traces] == [1, 2]
    assert [trace.file.complete for trace in traces] == [False, False]
    assert traces[1].header.gap is not None
    assert "No space left on device" in traces[1].header.gap.why
    assert traces[1].file.records[1].kind == "state"
    replayed = eehal("replay", run.folder)
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
    assert "records were not written" in replayed.stdout
    assert "The trace is not whole" in replayed.stdout
    for trace in traces:
        assert eehal("replay", trace.file.path).returncode == 0
    plotted = eehal("plot", run.folder)
    assert plotted.returncode == 0, plotted.stderr
    assert "rows of this recording could not be written" in plotted.stderr
    assert any("No space left on device" in gap for gap in read_run(run.folder).gaps)
    states = [row.end_effector for row in read_states(run.folder / "states.csv").rows]
    assert EndEffectorState.GRIPPED in states


def test_a_disk_that_is_full_before_the_start_is_told_before_anything_begins(
    world: World, disk: SmallDisk
) -> None:
    disk.fill()
    told = eehal("run", world.description_path, "--script", "lock", "--record", disk.path / "run")
    assert told.returncode == 2
    assert "No space left on device" in told.stderr
    assert "Traceback" not in told.stderr
