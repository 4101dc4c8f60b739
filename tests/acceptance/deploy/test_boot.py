"""The line arbiter as systemd really runs it: the shipped unit, booted in a container on an overlay of this machine."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.wires.lines import VirtualChip
from tests.support.places import DEPLOY

CHECK = Path(__file__).with_name("check_arbiter.py")
LINES = load(profile_path()).output_lines
GRIPPING = [actuator.line for _, actuator in load(profile_path()).ordered]
HELD = dict.fromkeys(LINES, False) | dict.fromkeys(GRIPPING, True)

pytestmark = [
    pytest.mark.wall,
    pytest.mark.timeout(180),
    pytest.mark.skipif(
        "EEHAL_BOOT" not in os.environ or os.geteuid() != 0 or not shutil.which("systemd-nspawn"),
        reason="by hand: make test-boot, as root, with Debian's systemd-container",
    ),
]


def run(*command: str | Path) -> None:
    subprocess.run(command, check=True, capture_output=True, timeout=30)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """This machine, whose changes are forgotten."""
    folder = tmp_path_factory.mktemp("boot")
    memory, merged = folder / "memory", folder / "root"
    for path in (memory, merged):
        path.mkdir()
    mounted = []
    try:
        try:
            run("mount", "-t", "tmpfs", "tmpfs", memory)
            mounted.append(memory)
            (memory / "upper").mkdir()
            (memory / "work").mkdir()
            options = f"lowerdir=/,upperdir={memory}/upper,workdir={memory}/work"
            run("mount", "-t", "overlay", "overlay", "-o", options, merged)
            mounted.append(merged)
        except subprocess.CalledProcessError as error:
            pytest.skip(f"no overlay can be mounted here: {error.stderr.decode().strip()}")
        yield merged
    finally:
        for path in reversed(mounted):
            run("umount", "-l", path)


def write(path: Path, text: str, mode: int = 0o644) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(mode)


@pytest.fixture(scope="module")
def seen(root: Path) -> dict:
    """What the check in the booted container saw."""
    etc = root / "etc/systemd/system"
    shutil.copy(DEPLOY / "systemd" / "eehal-arbiter@.service", etc)
    write(root / "etc/sysusers.d/eehal.conf", (DEPLOY / "systemd" / "eehal.sysusers").read_text())
    write(root / "etc/tmpfiles.d/eehal.conf", (DEPLOY / "systemd" / "eehal.tmpfiles").read_text())
    write(etc / "eehal-arbiter@.service.d/test.conf", "[Service]\nReadWritePaths=/bench\nWatchdogSec=2s\n")
    eehal = f"exec {sys.executable} -c 'from end_effector_hal.cli import main; main()' \"$@\""
    write(root / "opt/eehal/bin/eehal", f"#!/bin/sh\n{eehal}\n", 0o755)
    tool = profile_path().read_text().replace("backend: gpiod", "backend: virtual\n  path: /bench/chip\n")
    write(root / "etc/eehal/tool.yaml", tool)
    (root / "bench").mkdir()
    VirtualChip.create(root / "bench/chip", LINES, {"SODIMM_208": "up"})
    (root / "bench/chip.lock").unlink()
    (root / "bench/chip").chmod(0o666)
    (root / "bench").chmod(0o777)
    # what stands below /tmp is not seen in the container
    shutil.copy(CHECK, root / "bench/check_arbiter.py")
    write(
        etc / "check.service",
        "[Unit]\nAfter=eehal-arbiter@tool.service\n[Service]\nType=oneshot\nTimeoutStartSec=90\n"
        "Environment=EEHAL_RUN_DIR=/run/eehal\n"
        f"ExecStart={sys.executable} /bench/check_arbiter.py /bench/seen.json\n"
        "StandardError=file:/bench/error.log\nExecStopPost=/bin/systemctl poweroff --force\n",
    )
    write(
        etc / "check.target",
        "[Unit]\nRequires=basic.target\nWants=eehal-arbiter@tool.service check.service\n",
    )
    booted = subprocess.run(
        ["systemd-nspawn", "-D", root, "--register=no", "--keep-unit", "--private-network", "-b",
         "systemd.unit=check.target"],
        stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=150, check=False,
    )  # fmt: skip
    told = root / "bench/seen.json"
    error = root / "bench/error.log"
    if not error.exists():
        pytest.skip(f"systemd does not boot here: {(booted.stdout + booted.stderr)[-300:]}")
    assert told.exists(), error.read_text()
    found: dict = json.loads(told.read_text())
    return found


def test_it_is_ready_when_it_says_so(seen: dict) -> None:
    assert seen["active"] == "active"
    assert seen["status"] == "verdin_gripper on /run/eehal/verdin_gripper.sock"
    assert seen["serves"] is not None
    assert -10 < seen["active_after_ms"] < 2000, "systemd waits for READY=1, which follows the socket"


def test_the_claim_of_the_lines_and_the_journal_outlive_the_arbiter(seen: dict) -> None:
    assert [seen["stored"], seen["SIGKILL"]["stored"], seen["SIGSTOP"]["stored"]] == [1, 1, 1]
    assert seen["journal"] == ["verdin_gripper.sock.journal"]


def test_the_socket_is_for_the_group_gpio_only(seen: dict) -> None:
    gid = seen["/run/eehal"][1]
    assert seen["/run/eehal"][0] == "drwxrwx--T", "the programs put sockets there, and remove none of others"
    assert seen["/run/eehal/verdin_gripper.sock"] == ["srw-rw----", gid]
    assert gid != 0


@pytest.mark.parametrize(("signal", "within_s"), [("SIGKILL", 10.0), ("SIGSTOP", 15.0)])
def test_it_comes_back_and_no_line_moves(seen: dict, signal: str, within_s: float) -> None:
    found = seen[signal]
    assert found["seconds"] is not None
    assert found["seconds"] < within_s
    assert found["pid_shown"]
    assert found["levels"] == HELD


def test_a_stop_waits_for_the_end_of_a_will(seen: dict) -> None:
    found = seen["stop"]
    assert found["levels"] == dict.fromkeys(LINES, False)
    assert found["order"] == list(reversed(GRIPPING))
    assert all(550 <= gap < 1000 for gap in found["gaps_ms"]), found["gaps_ms"]
    assert (found["result"], found["seconds"] > 0.9) == ("success", True)
