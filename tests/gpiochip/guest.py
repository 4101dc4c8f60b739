"""A User-Mode-Linux machine for one command: this machine's files, and whatever hangs on its two wires."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
VIRTIO_GPIO = 41
READY = f"""
cd {shlex.quote(str(ROOT))}
. build/catkin/devel/setup.sh
export PATH={shlex.quote(str(ROOT / ".venv/bin"))}:$PATH PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1
"""


@dataclass(frozen=True)
class Ended:
    """What became of the command; ``code`` None: the machine ended before it did."""

    code: int | None
    output: str
    console: str
    seconds: float


def run_guest(
    kernel: Path, folder: Path, command: str, *, chip: Path | None = None, uart: Path | None = None,
    timeout_s: float = 240.0,
) -> Ended:  # fmt: skip
    """Boot, run a command of the shell in the project's environment, power off.

    Args:
        kernel: the program.
        folder: shared with the guest, at the same place; all else that it writes is forgotten.
        command: for sh.
        chip: socket of its GPIO chip.
        uart: the terminal that is its /dev/ttyS0.
        timeout_s: it is killed after that.
    """
    (folder / "command").write_text(READY + command)
    for name in ("code", "output"):
        (folder / name).unlink(missing_ok=True)
    words = [
        str(kernel), "mem=1024M", "root=none", "rootfstype=hostfs", "hostfs=/", "ro", "quiet",
        f"init={HERE / 'init.sh'}", f"run={HERE / 'guest.sh'}", f"share={folder}",
        f"uml_dir={folder}",
        "con=null", "con0=null,fd:1", "ssl=null",
        *([f"ssl0=tty:{uart}"] if uart else []),
        *([f"virtio_uml.device={chip}:{VIRTIO_GPIO}"] if chip else []),
    ]  # fmt: skip
    begun = time.monotonic()
    with (folder / "console").open("wb") as console:
        process = subprocess.Popen(
            [*_on_one_processor(), *words],
            stdin=subprocess.DEVNULL, stdout=console, stderr=console, start_new_session=True,
        )  # fmt: skip
        try:
            process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            pass
        finally:
            # every process of the guest is one of the host
            os.killpg(process.pid, signal.SIGKILL) if process.poll() is None else None
            process.wait()
    code, output = folder / "code", folder / "output"
    return Ended(
        int(code.read_text()) if code.exists() else None,
        output.read_text(errors="replace") if output.exists() else "",
        (folder / "console").read_text(errors="replace"),
        time.monotonic() - begun,
    )


def _on_one_processor() -> list[str]:
    """Its processes and its kernel take turns, thousands of times a second.

    Over two processors each turn costs twice as much. Behind other programs each waits for a time slice, and the guest
    is a hundred times too slow: where that is allowed it goes before them.
    """
    first = ["chrt", "--rr", "1"]
    allowed = subprocess.run([*first, "true"], capture_output=True, check=False).returncode == 0
    return [*(first if allowed else []), "taskset", "-c", str(max(os.sched_getaffinity(0)))]
