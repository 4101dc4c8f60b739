"""The emulated Verdin: QEMU, for one job of the shell; what that leaves in /run/results comes back."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import tarfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.demo._children import Children

ROOT = Path(__file__).parents[2]
HOME = Path("opt/end-effector")  # of the board
LIBRARIES = ("lib/x86_64-linux-gnu", "usr/lib/x86_64-linux-gnu")
BOOT = "console=ttymxc2 panic=-1 quiet nokaslr mitigations=off clk_ignore_unused"
EEHAL = "#!/usr/bin/env python3\nfrom end_effector_hal.cli import main\n\nmain()\n"


@dataclass(frozen=True)
class Ended:
    """What became of a job; ``code`` None: it did not end. ``seconds`` from power-up to power-off."""

    code: int | None
    output: str
    seconds: float


def write_root(parts: Path, place: Path, job: str, files: Mapping[str, str]) -> Path:
    """The board's memory at its start: what was built once, and on it the project as it stands, and the job."""
    more = place / "more"
    site, ros = more / HOME / "site", more / HOME / "ros"
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "src/end_effector_hal", site / "end_effector_hal", ignore=ignore)
    messages = ROOT / "build/catkin/devel/lib/python3/dist-packages/end_effector_msgs"
    shutil.copytree(messages, site / "end_effector_msgs", ignore=ignore)
    for package in ("end_effector_hal", "end_effector_msgs"):
        shutil.copytree(ROOT / "ros" / package, ros / package)
    init = Path(__file__).with_name("init.sh").read_text()
    contents = {"init": init, "job": job, "usr/bin/eehal": EEHAL, **files}
    for name, content in contents.items():
        path = more / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
        path.chmod(0o755)
    compiled = ["/usr/bin/python3.11", "-m", "compileall", "-q", "-s", str(more), str(more / HOME)]
    subprocess.run(compiled, check=True)
    names = sorted(str(path.relative_to(more)) for path in more.rglob("*"))
    archive = subprocess.run(
        ["busybox", "cpio", "-o", "-H", "newc"],
        input="\n".join(names).encode(), cwd=more, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True,
    ).stdout  # fmt: skip
    root = place / "root.cpio"
    with root.open("wb") as file, (parts / "root.cpio").open("rb") as built:
        shutil.copyfileobj(built, file, 1 << 20)
        file.write(bytes(-file.tell() % 4))  # archives one after the other begin at multiples of four
        file.write(archive)
    shutil.rmtree(more)
    return root


def qemu(parts: Path, root: Path, place: Path, folder: Path) -> tuple[list[str], dict[str, str]]:
    """Command and environment; the machine stands still until it is told to go on."""
    at = parts / "qemu"
    command = [
        str(at / "usr/bin/qemu-system-aarch64"), "-L", str(at / "usr/share/qemu"),
        "-M", "imx8mp-evk", "-accel", "tcg,thread=multi", "-smp", "2", "-m", "2G",
        "-kernel", str(parts / "kernel"), "-dtb", str(parts / "board.dtb"),
        "-initrd", str(root), "-append", BOOT,
        "-display", "none", "-monitor", "none", "-no-reboot", "-S",
        "-qmp", f"unix:{place / 'qmp'},server=on,wait=off",
        "-qtest", f"unix:{place / 'pins'},server=on,wait=off", "-qtest-log", "none",
        "-chardev", f"serial,id=uart,path={place / 'uart'}", "-serial", "chardev:uart",
        "-serial", f"file:{place / 'results.tar'}",
        "-serial", f"file:{folder / 'console'}",
    ]  # fmt: skip
    return command, {**os.environ, "LD_LIBRARY_PATH": ":".join(str(at / name) for name in LIBRARIES)}


def go_on(path: Path) -> None:
    """Let the machine run (QMP)."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(str(path))
        with connection.makefile("rw") as lines:
            lines.readline()
            for command in ("qmp_capabilities", "cont"):
                lines.write(json.dumps({"execute": command}) + "\n")
                lines.flush()
                while "return" not in json.loads(lines.readline()):
                    pass


def run_board(
    parts: Path, folder: Path, place: Path, job: str, testbench: list[str], *, files: Mapping[str, str] | None = None,
    timeout_s: float = 600.0,
) -> Ended:  # fmt: skip
    """Run a job on the board, with a testbench on its wires.

    Args:
        parts: what build-board.sh made.
        folder: gets ``results/``, the console and the testbench's log.
        place: for sockets and the root; its path is short.
        job: for bash, in the environment of the project.
        testbench: the command that plays the other end, without its places.
        files: more files for the board, by their path there.
        timeout_s: the board is switched off after that.
    """
    root = write_root(parts, place, job, files or {})
    with Children() as children:
        bench = children.start(
            "testbench",
            [*testbench, "--lines", f"qemu:{place / 'pins'}", "--port", f"pty:{place / 'uart'}"],
            log=folder / "testbench.log",
            commands=True,
        )
        bench.wait_until((place / "uart").exists, timeout_s=60, what="its port")
        command, env = qemu(parts, root, place, folder)
        begun = time.monotonic()
        machine = children.start("emulated board", command, log=folder / "qemu.log", env=env)
        bench.wait_until(lambda: "ready:" in bench.text(), timeout_s=60, what="it was ready")
        go_on(place / "qmp")
        machine.wait_for_end(timeout_s=timeout_s)
        seconds = time.monotonic() - begun
    with tarfile.open(place / "results.tar") as results:
        results.extractall(folder)
    code, output = folder / "results" / "code", folder / "results" / "output"
    return Ended(
        int(code.read_text()) if code.exists() else None, output.read_text(errors="replace"), seconds
    )
