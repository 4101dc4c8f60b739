"""The package on a fresh Debian 12 that systemd has booted: installed, gripping, killed, upgraded, removed, purged;
two tools, a codec and a program of one's own.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from tests.support.patience import wait_until
from tests.support.places import ROOT

TOOL, GAUGE_TOOL = "/etc/eehal/my_tool.yaml", "/etc/eehal/gauge_tool.yaml"
PARTS = ("eehal-arbiter@my_tool", "eehal@my_tool", "eehal-arbiter@gauge_tool", "eehal@gauge_tool")
GAUGE, PROGRAM = ROOT / "examples/codecs/gauge", ROOT / "examples/programs/ten_grips.py"
PACKAGES = "systemd,systemd-sysv,dbus,ca-certificates,python3"
BOOT_S = 120.0

pytestmark = [
    pytest.mark.wall,
    pytest.mark.timeout(1800),
    pytest.mark.skipif(
        "EEHAL_BOOT" not in os.environ or not (shutil.which("systemd-nspawn") and shutil.which("mmdebstrap")),
        reason="by hand: make test-boot, as root, with Debian's systemd-container and mmdebstrap",
    ),
]


class Machine:
    """A booted Debian; ``pid`` is that of its systemd."""

    def __init__(self, pid: int) -> None:
        self._pid = pid

    def run(self, script: str) -> tuple[int, str]:
        """The exit code of a line for sh, and what it printed."""
        done = subprocess.run(
            ["nsenter", "-t", str(self._pid), "-a", "--", "env", "-i", "LANG=C.UTF-8",
             "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "DEBIAN_FRONTEND=noninteractive", "sh", "-c", script],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout

    def does(self, script: str) -> str:
        code, said = self.run(script)
        assert code == 0, said
        return said

    def states(self) -> list[str]:
        """The state of each tool."""
        found = (re.match(r"\w+: (\w+)", self.run(f"eehal status {tool}")[1]) for tool in (TOOL, GAUGE_TOOL))
        return [each[1] if each else "" for each in found]

    def reach(self, *states: str) -> None:
        wait_until(" ".join(states), lambda: self.states()[: len(states)] == [*states])

    def pids(self) -> list[str]:
        return [self.does(f"systemctl show -P MainPID {part}").strip() for part in PARTS]


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The package that `make deb` has built, and a later version of it."""
    built = sorted((ROOT / "build").glob("end-effector-hal_*_amd64.deb"))
    assert built, "make deb"
    folder = tmp_path_factory.mktemp("later")
    subprocess.run(["dpkg-deb", "-R", built[-1], folder / "root"], check=True)
    control = folder / "root/DEBIAN/control"
    control.write_text(re.sub(r"(?m)^(Version: .*)$", r"\1+later", control.read_text()))
    command = ["dpkg-deb", "--root-owner-group", "-Zgzip", "-z1", "-b", folder / "root", folder / "later.deb"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return built[-1], folder / "later.deb"


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory, packages: tuple[Path, Path]) -> Iterator[Machine]:
    folder = tmp_path_factory.mktemp("debian")
    root = folder / "root"
    subprocess.run(
        ["mmdebstrap", "--quiet", "--variant=minbase", f"--include={PACKAGES}", "--dpkgopt=force-unsafe-io",
         "bookworm", root],
        check=True,
    )  # fmt: skip
    for name, package in zip(("first.deb", "later.deb"), packages, strict=True):
        shutil.copy(package, root / "root" / name)
    (root / "etc/eehal").mkdir()
    for path, source in ((TOOL, profile_path()), (GAUGE_TOOL, GAUGE / "end_effector.yaml")):
        wires = f"/run/eehal/{Path(path).stem}"
        tool = re.sub(r"port: [^\s,]+", f"port: {wires}.uart", source.read_text(), count=1)
        tool = tool.replace("{backend: gpiod}", "\n  backend: gpiod")
        (root / path[1:]).write_text(
            tool.replace("backend: gpiod", f"backend: virtual\n  path: {wires}.chip")
        )
    shutil.copy(PROGRAM, root / "etc/eehal")
    shutil.copytree(GAUGE, root / "root/gauge")
    with (folder / "log").open("w") as log:
        nspawn = subprocess.Popen(
            ["systemd-nspawn", "-D", root, "--register=no", "--keep-unit", "--private-network", "-b"],
            stdin=subprocess.DEVNULL, stdout=log, stderr=log,
        )  # fmt: skip
        try:
            yield booted(nspawn.pid, folder / "log")
        finally:
            nspawn.terminate()
            nspawn.wait(60)


def booted(parent: int, log: Path) -> Machine:
    end = time.monotonic() + BOOT_S
    while time.monotonic() < end:
        children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
        if children and Machine(int(children[0])).run("systemctl is-system-running")[1].strip() in (
            "running",
            "degraded",
        ):
            return Machine(int(children[0]))
        time.sleep(0.5)
    pytest.skip(f"systemd does not boot here: {log.read_text()[-300:]}")


def bench(machine: Machine, tool: str, scenario: str) -> None:
    """Start the simulated hardware of a tool."""
    name = Path(tool).stem
    options = f"--unit=bench-{name} --gid=gpio -p UMask=0002"
    machine.does(f"systemd-run {options} eehal testbench {tool} --scenario {scenario}")
    wait_until("the testbench", lambda: machine.run(f"test -L /run/eehal/{name}.uart")[0] == 0)


def a_codec_and_a_second_tool(machine: Machine) -> None:
    """A tool whose codec is a plug-in, beside the first one."""
    code, said = machine.run(f"eehal check {GAUGE_TOOL}")
    assert (code, "there is no such codec (gauge)" in said) == (2, True)
    assert "codec gauge" in machine.does("eehal plugin add /root/gauge")
    bench(machine, GAUGE_TOOL, "fails-once:cup")
    machine.does("systemctl enable --now eehal@gauge_tool")
    machine.reach("STAND_BY", "STAND_BY")


def a_program(machine: Machine) -> None:
    """A program as a service: its options are a drop-in; it grips twice, and is not started again."""
    unit = "eehal-program@ten_grips"
    folder = f"/etc/systemd/system/{unit}.service.d"
    option = f'[Service]\\nEnvironment="EEHAL_OPTIONS={TOOL} 2"\\n'
    machine.does(f"mkdir {folder} && printf '{option}' >{folder}/options.conf && systemctl daemon-reload")
    machine.does(f"systemctl start {unit}")
    wait_until("its end", lambda: machine.does(f"systemctl show -P ActiveState {unit}").strip() == "inactive")
    assert "2 of 2 grips confirmed" in machine.does(f"journalctl -u {unit} -o cat --no-pager")
    assert machine.does(f"systemctl show -P NRestarts -P User {unit}").split() == ["0", "eehal"]


def test_from_the_installation_to_the_purge(machine: Machine) -> None:
    """One story, since each step needs the one before."""
    machine.does("apt-get install -y /root/first.deb")
    machine.does(f"eehal check {TOOL}")
    bench(machine, TOOL, "nominal")
    machine.does("systemctl enable --now eehal@my_tool")
    machine.reach("STAND_BY")
    machine.does("systemctl start eehal-recorder@my_tool eehal-page@my_tool")
    wait_until(
        "the page", lambda: "/?token=" in machine.run("journalctl -u eehal-page@my_tool -o cat --no-pager")[1]
    )
    code, said = machine.run("systemctl start eehal@mistyped")
    assert (code, "Assertion failed" in said) == (1, True)
    machine.does("systemctl stop eehal-arbiter@mistyped")
    a_codec_and_a_second_tool(machine)
    a_program(machine)

    for tool, words in ((TOOL, "lock; grip"), (GAUGE_TOOL, "grip")):
        machine.does(f"eehal do {tool} '{words}'")
    moved = machine.does("cat /run/eehal/*.chip")

    def held() -> None:
        machine.reach("GRIPPED", "GRIPPED")
        assert machine.does("cat /run/eehal/*.chip") == moved, "no line changes"

    said = machine.does(
        "journalctl EEHAL_TOOL=gauge_tool EEHAL_EVENT=TimedOut EEHAL_ACTUATOR=cup -o cat --no-pager"
    )
    assert said == "Cup was not confirmed within 5 s: attempt 1 of 3.\n"
    found = (
        "journalctl EEHAL_EVENT=StateChanged EEHAL_STATE=GRIPPED -o cat --no-pager --output-fields=EEHAL_TOOL"
    )
    assert machine.does(found).splitlines() == [*["verdin_gripper"] * 3, "gauge_tool"]

    machine.does("systemctl kill -s KILL eehal-arbiter@my_tool")
    held()
    machine.does(f"systemctl restart {' '.join(PARTS)}")
    held()
    before = machine.pids()
    said = machine.does("apt-get install -y /root/later.deb")
    for tool in ("my_tool", "gauge_tool"):
        assert f"{tool} is not at rest: the version before goes on." in said
    assert machine.pids() == before
    held()
    code, said = machine.run("apt-get remove -y end-effector-hal")
    assert code
    assert "gauge_tool may hold something" in said, "the first that does"
    assert machine.pids() == before
    held()

    for tool in (TOOL, GAUGE_TOOL):
        machine.does(f"eehal do {tool} drop")
    machine.does("apt-get install -y --allow-downgrades /root/first.deb")
    assert not set(machine.pids()) & set(before), "at rest it gets the new programs"
    machine.reach("STAND_BY", "STAND_BY")
    assert re.search(r"^eehal-gauge .* yes *$", machine.does("eehal plugin list"), re.MULTILINE)
    machine.does("apt-get remove -y end-effector-hal && test -d /opt/eehal/plugins/eehal-gauge")
    said = machine.does("apt-get purge -y end-effector-hal")
    assert "rm -r /var/log/eehal" in said
    machine.does(f"test -s {TOOL} && test -s /var/log/eehal/my_tool/run/states.csv && ! test -e /opt/eehal")
    assert "@my_tool" not in machine.does(
        "systemctl list-units --no-legend 'eehal*'; ls /etc/systemd/system/*"
    )
