"""The package on a fresh Debian that systemd has booted: installed, gripping, killed, upgraded, removed, purged; two
tools, a codec and a program of one's own, full disks, the nodes of ROS 1.

EEHAL_BOOT_BASE names another Debian than 12 (bookworm), such as trixie: the package is built in it, without ROS.
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
from tests.support.places import DEPLOY, ROOT

TOOL, GAUGE_TOOL = "/etc/eehal/my_tool.yaml", "/etc/eehal/gauge_tool.yaml"
PARTS = ("eehal-arbiter@my_tool", "eehal@my_tool", "eehal-arbiter@gauge_tool", "eehal@gauge_tool")
GAUGE, PROGRAM = ROOT / "examples/codecs/gauge", ROOT / "examples/programs/ten_grips.py"
BASE = os.environ.get("EEHAL_BOOT_BASE", "bookworm")
OWN = "python3-venv" if BASE != "bookworm" else (DEPLOY / "container/packages.txt").read_text()
"""What the package is built with in that Debian, or the ROS 1 of Debian 12."""
PACKAGES = ["systemd", "systemd-sysv", "dbus", "ca-certificates", "python3", *OWN.split()]
NODES = "/lib/systemd/system/eehal-ros1@.service"
SMALL = ("/var/log/eehal", "/var/lib/eehal-arbiter")
"""The recordings, and what the arbiters have latched."""
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
        self.has_nodes = False

    def run(self, script: str) -> tuple[int, str]:
        """The exit code of a line for sh, and what it printed."""
        done = subprocess.run(
            ["nsenter", "-t", str(self._pid), "-a", "--", "env", "-i", "LANG=C.UTF-8", "HOME=/root",
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


def built(root: Path) -> Path:
    """The package that `make deb` has built, or that of another Debian, built in it."""
    folder = ROOT / "build"
    if BASE != "bookworm":
        (folder := root / "root/build").mkdir()
        source = root / "root/source"
        subprocess.run(["git", "clone", "-q", ROOT, source], check=True)
        certificates = "/etc/ssl/certs/ca-certificates.crt"
        shutil.copy(certificates, root / certificates[1:])
        subprocess.run(
            ["chroot", root, "env", "-i", "HOME=/root", "LANG=C.UTF-8", "PATH=/usr/sbin:/usr/bin:/sbin:/bin",
             f"SSL_CERT_FILE={certificates}", "/root/source/deploy/package.sh", "/root/build"],
            check=True,
        )  # fmt: skip
    found = sorted(folder.glob("end-effector-hal_*_amd64.deb"))
    assert found, "make deb"
    return found[-1]


def later(package: Path, folder: Path) -> Path:
    """The same package as a later version."""
    subprocess.run(["dpkg-deb", "-R", str(package), str(folder / "later")], check=True)
    control = folder / "later/DEBIAN/control"
    control.write_text(re.sub(r"(?m)^(Version: .*)$", r"\1+later", control.read_text()))
    options = ("--root-owner-group", "-Zgzip", "-z1")
    subprocess.run(["dpkg-deb", *options, "-b", folder / "later", folder / "later.deb"], check=True)
    return folder / "later.deb"


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machine]:
    folder = tmp_path_factory.mktemp("debian")
    root = folder / "root"
    subprocess.run(
        ["mmdebstrap", "--quiet", "--variant=minbase", f"--include={','.join(PACKAGES)}",
         "--dpkgopt=force-unsafe-io", BASE, root],
        check=True,
    )  # fmt: skip
    shutil.copy(first := built(root), root / "root/first.deb")
    shutil.copy(later(first, folder), root / "root/later.deb")
    (root / "etc/eehal").mkdir()
    (root / "etc/hosts").write_text("127.0.0.1 localhost\n")  # the installer of Debian writes it
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


def nodes_of_ros_1(machine: Machine) -> None:
    """The nodes of ROS 1, where the package has them."""
    machine.has_nodes = machine.run(f"test -e {NODES}")[0] == 0
    assert machine.has_nodes is (BASE == "bookworm")
    if machine.has_nodes:
        machine.does("systemctl start eehal-ros1@my_tool")
        publishing(machine)


def publishing(machine: Machine) -> None:
    topic = "timeout 10 /opt/eehal/bin/eehal-container rostopic echo -n 1 /EndEffectorState"
    wait_until("the state by ROS", lambda: machine.run(topic)[0] == 0)


def full_disks(machine: Machine) -> None:
    """Without room a tool grips and drops, a stop survives the death of the arbiter, and a recording goes on later."""
    folders = " ".join(f"{folder}/filler" for folder in SMALL)
    assert machine.run(f"for each in {folders}; do cat /dev/zero >$each; done")[0], "they are full"
    machine.does(f"eehal do {TOOL} 'lock; grip; drop; grip'")
    machine.does(f"eehal stop {TOOL}")
    moved = machine.does("cat /run/eehal/my_tool.chip")
    said = "journalctl -o cat --no-pager -u eehal-recorder@my_tool"
    lost = "Rows of the recording cannot be written.*No space left on device"
    wait_until("the reason", lambda: re.search(lost, machine.does(said)))
    machine.does("systemctl kill -s KILL eehal-arbiter@my_tool")
    machine.reach("GRIPPED")
    machine.does(f"rm {folders}")
    assert "IL-13: the tool was stopped" in machine.does(f"eehal status {TOOL}")
    assert machine.does("cat /run/eehal/my_tool.chip") == moved, "no line changes"
    machine.does(f"eehal do {TOOL} 'reset; drop'")
    run = "/var/log/eehal/my_tool/run"
    wait_until("the recording goes on", lambda: "could not be written" in machine.does(f"cat {run}/run.json"))
    wait_until("the last state", lambda: ",6,-1," in machine.does(f"tail -n 1 {run}/states.csv"))


def test_from_the_installation_to_the_purge(machine: Machine) -> None:
    """One story, since each step needs the one before."""
    machine.does("apt-get install -y /root/first.deb")
    machine.does(f"eehal check {TOOL}")
    for folder in SMALL:
        machine.does(f"mkdir -p {folder} && mount -t tmpfs -o size=8m tmpfs {folder}")
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
    nodes_of_ros_1(machine)
    full_disks(machine)

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
    assert machine.does(found).splitlines() == [*["verdin_gripper"] * 5, "gauge_tool"]

    machine.does("systemctl kill -s KILL eehal-arbiter@my_tool")
    held()
    machine.does(f"systemctl restart {' '.join(PARTS)}")
    held()
    if machine.has_nodes:
        machine.does("systemctl kill -s KILL eehal-ros1@my_tool")
        publishing(machine)
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
