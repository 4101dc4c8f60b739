"""A User-Mode-Linux machine for one command: this machine's files, and whatever hangs on its two wires."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from tests.acceptance.gpiochip.priority import GUEST, MEMORY, before_others
from tests.support.places import ROOT

HERE = Path(__file__).parent
VIRTIO_GPIO = 41
READY = f"""
cd {shlex.quote(str(ROOT))}
. build/catkin/devel/setup.sh
export PATH={shlex.quote(str(ROOT / ".venv/bin"))}:$PATH PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1
"""
POWER_S = 30.0
"""To boot, and to switch off."""


@dataclass(frozen=True)
class Stall:
    """The machine stood still; µs of its own clock."""

    until: int
    length: int


@dataclass(frozen=True)
class Ended:
    """What became of the command; ``code`` None: the machine ended before it did."""

    code: int | None
    output: str
    console: str
    seconds: float
    stalls: tuple[Stall, ...] = ()

    def longest_stall_s(self, begin_us: int, end_us: int) -> float:
        """The longest time in which the machine stood still between two moments of its clock."""
        lengths = [
            each.length for each in self.stalls if each.until > begin_us and each.until - each.length < end_us
        ]
        return max(lengths, default=0) / 1e6


def run_guest(
    kernel: Path, folder: Path, command: str, *, chip: Path | None = None, uart: Path | None = None,
    timeout_s: float = 240.0,
) -> Ended:  # fmt: skip
    """Boot, run a command of the shell in the project's environment, power off.

    Args:
        kernel: the program.
        folder: gets what the command leaves in $RESULTS, and what it says; all else that it writes is forgotten.
        command: for sh.
        chip: socket of its GPIO chip.
        uart: the terminal that is its /dev/ttyS0.
        timeout_s: the command is ended after that.
    """
    (folder / "command").write_text(READY + command)
    for name in ("code", "output", "stalls"):
        (folder / name).unlink(missing_ok=True)
    words = [
        str(kernel), "mem=1024M", "root=none", "rootfstype=hostfs", "hostfs=/", "ro", "quiet",
        f"init={HERE / 'init.sh'}", f"run={HERE / 'guest.sh'}", f"share={folder}", f"patience={timeout_s:.0f}",
        f"uml_dir={folder}",
        "con=null", "con0=null,fd:1", "ssl=null",
        *([f"ssl0=tty:{uart}"] if uart else []),
        *([f"virtio_uml.device={chip}:{VIRTIO_GPIO}"] if chip else []),
    ]  # fmt: skip
    begun = time.monotonic()
    with (folder / "console").open("wb") as console:
        process = subprocess.Popen(
            [*before_others(GUEST), *_on_one_processor(), *words],
            stdin=subprocess.DEVNULL, stdout=console, stderr=console, start_new_session=True,
            env={**os.environ, "TMPDIR": MEMORY},  # its memory is a file
        )  # fmt: skip
        try:
            process.wait(timeout_s + POWER_S)
        except subprocess.TimeoutExpired:
            pass
        finally:
            # every process of the guest is one of the host
            os.killpg(process.pid, signal.SIGKILL) if process.poll() is None else None
            process.wait()
    code = _read(folder / "code")
    return Ended(
        int(code) if code else None,
        _read(folder / "output"),
        _read(folder / "console"),
        time.monotonic() - begun,
        tuple(Stall(*map(int, line.split())) for line in _read(folder / "stalls").splitlines()),
    )


def _on_one_processor() -> list[str]:
    """Its processes and its kernel take turns, thousands of times a second: over two processors that costs twice."""
    return ["taskset", "-c", str(max(os.sched_getaffinity(0)))]


def _read(path: Path) -> str:
    return path.read_text(errors="replace") if path.exists() else ""
