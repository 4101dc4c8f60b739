"""The emulated board, from power-up to power-off, for one shell job."""

from __future__ import annotations

import json
import os
import re
import socket
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from end_effector_lab.processes import Child, Children

from ._errors import BoardError
from ._root import write_root

LIBRARIES = ("lib", "usr/lib")
BOOT = "console=ttymxc2 panic=-1 quiet nokaslr mitigations=off clk_ignore_unused"
CLOCK = ("-icount", "shift=0,sleep=on", "-rtc", "clock=vm")
"""The board's time counts executed instructions, 1 ns each: on a busy host it runs slower, but nothing in it is late.

The board must not idle (init.sh): otherwise its time would follow the host's, and the testbench could be late.
"""
START_S = 120.0
LONGEST_S = 1800.0


@dataclass(frozen=True)
class Ended:
    """Result of a job; ``code`` None: not ended. ``seconds``: power-up to power-off, by the host's clock."""

    code: int | None
    output: str
    seconds: float


def run_board(
    parts: Path,
    folder: Path,
    job: str,
    *,
    testbench: Sequence[str] = (),
    files: Mapping[str, str] | None = None,
    ros: bool = True,
    timeout_s: float = LONGEST_S,
    while_running: Callable[[], None] = lambda: None,
) -> Ended:
    """Run a job on the board, with a testbench on its wires.

    Args:
        parts: see `board_parts`.
        folder: receives ``results/`` (the job's files in /run/results), the console, the logs and ``events``.
        job: bash script, run in the environment of the project.
        testbench: arguments for `tools.testbench`, except its paths.
        files: text of more files, by their path on the board.
        ros: whether to include the nodes and their messages.
        timeout_s: time after which the board is switched off, by the host's clock.
        while_running: called a few times a second.

    Raises:
        RosError: ROS is requested and missing.
        ReportedError: QEMU or the testbench does not start, or the board does not end.
    """
    # a socket's path may be 108 bytes long only: not in the folder of the run
    with tempfile.TemporaryDirectory(prefix="eehal-board-") as name, Children() as children:
        place = Path(name)
        root = write_root(parts, place, job, files or {}, ros=ros)
        bench = children.start(
            "testbench",
            [
                sys.executable, "-m", "tools.testbench", *testbench, "--events", str(folder / "events"),
                "--lines", f"qemu:{place / 'pins'}", "--port", f"pty:{place / 'uart'}",
            ],
            log=folder / "testbench.log",
            commands=True,
        )  # fmt: skip
        bench.wait_until((place / "uart").exists, timeout_s=START_S, what="its port")
        command, libraries = _qemu(parts, root, place, folder)
        begun = time.monotonic()
        board = children.start(
            "emulated board", command, log=folder / "qemu.log", env=libraries, failed=BoardError
        )
        board.wait_until(lambda: _ready(bench), timeout_s=START_S, what="the testbench saw its pins")
        _switch_on(place / "qmp")
        _wait(board, begun + timeout_s, while_running)
        seconds = time.monotonic() - begun
        return Ended(*_results(place / "results.tar", folder), seconds)


def _qemu(parts: Path, root: Path, place: Path, folder: Path) -> tuple[list[str], dict[str, str]]:
    """Return command and environment; the machine is paused until it is switched on."""
    at = parts / "qemu"
    command = [
        str(at / "usr/bin/qemu-system-aarch64"), "-L", str(at / "usr/share/qemu"),
        "-M", "imx8mp-evk", "-accel", "tcg", *CLOCK, "-smp", "1", "-m", "2G",
        "-kernel", str(parts / "kernel"), "-dtb", str(parts / "board.dtb"),
        "-initrd", str(root), "-append", BOOT,
        "-display", "none", "-monitor", "none", "-no-reboot", "-S",
        "-qmp", f"unix:{place / 'qmp'},server=on,wait=off",
        "-qtest", f"unix:{place / 'pins'},server=on,wait=off", "-qtest-log", "none",
        "-chardev", f"serial,id=uart,path={place / 'uart'}", "-serial", "chardev:uart",
        "-serial", f"file:{place / 'results.tar'}",
        "-serial", f"file:{folder / 'console'}",
    ]  # fmt: skip
    folders = [
        *(at / name for name in LIBRARIES),
        *at.glob("lib/*-linux-gnu"),
        *at.glob("usr/lib/*-linux-gnu"),
    ]
    return command, {"LD_LIBRARY_PATH": os.pathsep.join(map(str, folders))}


def _ready(bench: Child) -> bool:
    if bench.code is not None:
        raise bench.error("The testbench has ended.")
    return "ready:" in bench.text()


def _switch_on(path: Path) -> None:
    """Start the machine (QMP)."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(str(path))
        with connection.makefile("rw") as lines:
            lines.readline()
            for command in ("qmp_capabilities", "cont"):
                lines.write(json.dumps({"execute": command}) + "\n")
                lines.flush()
                while "return" not in json.loads(lines.readline()):
                    pass


def _wait(board: Child, end: float, while_running: Callable[[], None]) -> None:
    while board.code is None:
        if time.monotonic() > end:
            raise board.error("The emulated board did not end in time.")
        time.sleep(0.2)
        while_running()


def _results(archive: Path, folder: Path) -> tuple[int | None, str]:
    """Unpack the data of the second serial port; return the exit code and output of the job."""
    try:
        with tarfile.open(archive) as results:
            if hasattr(tarfile, "data_filter"):
                results.extraction_filter = tarfile.data_filter
            results.extractall(folder)
    except (OSError, tarfile.TarError):
        console = (folder / "console").read_text(errors="replace")
        return None, re.sub(r"\x1b\[[0-9;]*m", "", console)
    code, output = folder / "results" / "code", folder / "results" / "output"
    return int(code.read_text()) if code.exists() else None, output.read_text(errors="replace")
