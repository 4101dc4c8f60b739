"""The program as a user has it: a process, a virtual chip, a pty. In wall time, so with generous limits."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from queue import Queue
from subprocess import DEVNULL, PIPE

import pytest

from end_effector_hal.signals import Frame
from end_effector_hal.wires.lines import VirtualLines
from end_effector_hal.wires.link._reader import LinkReader
from tests.support.nightly import first_of
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.wall

LINES = ["SODIMM_206", "SODIMM_208", "SODIMM_210", "SODIMM_212"]
MAIN = "from end_effector_hal.cli import main; main()"
Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    processes = []

    def start(*options: str, stdin: int = PIPE, stdout: int = PIPE) -> subprocess.Popen[str]:
        where = ["--lines", f"virtual:{tmp_path}/chip", "--port", f"pty:{tmp_path}/uart"]
        program = [sys.executable, "-c", MAIN, "testbench", *where, *options]
        process = subprocess.Popen(program, stdin=stdin, stdout=stdout, stderr=PIPE, text=True)
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream:
                with suppress(OSError):
                    stream.close()


def line(process: subprocess.Popen[str]) -> str:
    assert process.stdout
    return process.stdout.readline().rstrip("\n")


def end(process: subprocess.Popen[str], number: int = signal.SIGTERM) -> tuple[int, str]:
    """Exit code and what stood on standard error."""
    process.send_signal(number)
    assert process.stderr
    return process.wait(PATIENCE_S), process.stderr.read()


def wait_for(frames: Queue[Frame], condition: Callable[[Frame], bool]) -> Frame:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        frame = frames.get(timeout=PATIENCE_S)
        if condition(frame):
            return frame
    raise AssertionError("no such frame came")


def test_lines_in_frames_out(start: Start, tmp_path: Path) -> None:
    process = start("--verbose", "--events", f"{tmp_path}/events")
    assert line(process) == (
        f"ready: verdin_gripper, scenario nominal, seed 0, lines virtual:{tmp_path}/chip, port {tmp_path}/uart, "
        "ees1-ascii at 50 Hz"
    )
    frames: Queue[Frame] = Queue()
    lines = VirtualLines(tmp_path / "chip")
    with LinkReader(f"{tmp_path}/uart", "ees1-ascii", on_frame=frames.put) as reader:
        lines.request(LINES)
        first = wait_for(frames, lambda frame: True)
        assert first.values["bottom"] == pytest.approx(0, abs=500)
        lines.set({"SODIMM_208": True})
        confirmed = wait_for(frames, lambda frame: frame.values["bottom"] < -55_000)  # type: ignore[operator]
        assert confirmed.values["top"] == pytest.approx(0, abs=500)
        assert confirmed.values["locked"] is True

        assert process.stdin
        print("scenario never-confirms:cylinder,supply:500", file=process.stdin, flush=True)
        wait_for(frames, lambda frame: frame.values["supply"] < 510_000)  # type: ignore[operator]
        lines.set({"SODIMM_210": True, "SODIMM_212": True})
        both = wait_for(frames, lambda frame: frame.values["top"] < -55_000)  # type: ignore[operator]
        assert both.values["cylinder_extended"] is False
        health = reader.health
    lines.close()
    assert end(process) == (0, "")
    assert (health.lost, sum(health.errors.values())) == (0, 0)
    assert not (tmp_path / "uart").is_symlink()
    assert (tmp_path / "chip").exists()  # like registers

    assert process.stdout
    said = process.stdout.read()
    assert "SODIMM_208 active\nscenario: never-confirms:cylinder,supply:500\n" in said
    entries = [json.loads(text) for text in (tmp_path / "events").read_text().splitlines()]
    edges = [(entry["line"], entry["level"]) for entry in entries if "line" in entry]
    assert edges[-3:] == [("SODIMM_208", 1), ("SODIMM_210", 1), ("SODIMM_212", 1)]
    assert all(0 <= entry["seen"] - entry["at"] < 5_000_000 for entry in entries if "line" in entry)
    assert any("frame" in entry for entry in entries)


def test_a_bench_started_anew_finds_what_is_held(start: Start, tmp_path: Path) -> None:
    frames: Queue[Frame] = Queue()
    before = start()
    line(before)
    lines = VirtualLines(tmp_path / "chip")
    lines.request(LINES)
    lines.set({"SODIMM_208": True})
    before.kill()
    before.wait()
    line(start("--json"))
    with LinkReader(f"{tmp_path}/uart", "ees1-ascii", on_frame=frames.put):
        assert wait_for(frames, lambda frame: True).values["bottom"] == pytest.approx(-85_000, abs=500)
    lines.close()


@pytest.mark.parametrize("number", first_of([signal.SIGINT, signal.SIGHUP]))
def test_signals_end_it_cleanly(start: Start, number: int) -> None:
    process = start(stdin=DEVNULL)
    line(process)
    assert end(process, number) == (0, "")


def test_quit_ends_it(start: Start) -> None:
    process = start()
    line(process)
    assert process.communicate("scenario leak:cylinder\nquit\n", timeout=PATIENCE_S) == (
        "",
        "refused: 'leak:cylinder': cylinder cannot have this fault. It can have: fails-once, fails, never-confirms, "
        "stuck-release, lost-after, invalid, shows, frozen-after, swapped.\n",
    )
    assert process.returncode == 0


def test_a_serial_port_that_goes_is_said(start: Start) -> None:
    master, slave = os.openpty()
    process = start("--port", os.ttyname(slave), stdin=DEVNULL)
    os.close(slave)
    assert line(process).startswith("ready:")
    os.close(master)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, "the port has gone" in said, "Traceback" in said) == (3, True, False), said


def test_a_reader_of_its_output_that_goes_away_is_no_reason_to_stop(start: Start, tmp_path: Path) -> None:
    read, write = os.pipe()
    process = start("--verbose", stdout=write)
    os.close(write)
    assert os.read(read, 200).startswith(b"ready:")
    os.close(read)
    lines = VirtualLines(tmp_path / "chip")
    lines.request(LINES)
    frames: Queue[Frame] = Queue()
    with LinkReader(f"{tmp_path}/uart", "ees1-ascii", on_frame=frames.put):
        lines.set({"SODIMM_208": True})
        wait_for(frames, lambda frame: frame.values["bottom"] < -55_000)  # type: ignore[operator]
    lines.close()
    assert end(process) == (0, "")


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--scenario", "fails-once:cylinda"], 2, "Did you mean 'cylinder'?"),
        pytest.param(["--lines", "rpi4"], 2, "Expected: virtual:PATH", marks=pytest.mark.thinned),
        (["--port", "/dev/nothing"], 3, "the port does not exist"),
        pytest.param(["--events", "/dev/full"], 2, "No space left", marks=pytest.mark.thinned),
        pytest.param(["nothing.yaml"], 2, "nothing.yaml", marks=pytest.mark.thinned),
    ],
)
def test_what_cannot_be_used_is_said_in_a_sentence(
    start: Start, options: list[str], code: int, message: str
) -> None:
    process = start(*options, stdin=DEVNULL)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, message in said, "Traceback" in said) == (code, True, False), said
