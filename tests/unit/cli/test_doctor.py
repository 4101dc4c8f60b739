"""``eehal doctor`` on real parts: a virtual chip, a pty, a line arbiter, and on machines that lack them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.arbiter import ArbiterServer
from end_effector_hal.cli.doctor import _arbiter, _doctor, _lines, _link, _machine, _ros
from end_effector_hal.cli.doctor._check_result import CheckResult, Level
from end_effector_hal.cli.doctor._holders import holders_of
from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.runtime import arbiter_policy, output_lines
from end_effector_hal.signals import Frame
from end_effector_hal.wires.lines import VirtualChip, VirtualLines, read_chip
from end_effector_hal.wires.link import PtyPair
from end_effector_lab.demo._world import EEHAL, World
from tests.support.proving import proving
from tests.support.stranger import as_nobody

LINES = output_lines(load(profile_path()))
CODEC = get_codec("ees1-ascii")
PRESSURES = {"bottom": -70_000, "cylinder": 600_000, "top": 0, "supply": 600_000}


class Machine:
    """A folder with the wires of a tool, and the doctor who looks at them."""

    def __init__(self, folder: Path) -> None:
        self.chip, self.port, self.socket = folder / "chip", folder / "uart", folder / "owner.sock"
        self.path = folder / "tool.yaml"
        self.describe()

    def describe(self, codec: str = "ees1-ascii", text: str = "") -> None:
        """Write the description: the shipped one on this folder's wires."""
        shipped = profile_path().read_text(encoding="utf-8")
        virtual = f"backend: virtual\n  path: {self.chip}\n  socket: {self.socket}\n"
        shipped = shipped.replace("backend: gpiod", virtual).replace("/dev/verdin-uart1", str(self.port))
        self.path.write_text(text or shipped.replace("codec: ees1-ascii", f"codec: {codec}"))

    def make_chip(self) -> None:
        """As the testbench does."""
        VirtualChip.create(self.chip, LINES)

    def doctor(self, *arguments: str) -> Result:
        """Run the command."""
        return CliRunner().invoke(_doctor.command, [str(self.path), *arguments], catch_exceptions=False)

    def findings(self, part: str, *arguments: str) -> list[tuple[str, str, str]]:
        """Level, sentence and advice of one part."""
        told = json.loads(self.doctor("--only", part, "--json", *arguments).stdout)["findings"]
        return [(each["status"], each["what"], each["todo"]) for each in told if each["part"] == part]

    def finding(self, part: str, *arguments: str) -> tuple[str, str, str]:
        """The only one."""
        (only,) = self.findings(part, *arguments)
        return only


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    return Machine(tmp_path)


@pytest.fixture
def arbiter(machine: Machine) -> Iterator[ArbiterServer]:
    with serving(machine) as running:
        yield running


@contextmanager
def serving(machine: Machine) -> Iterator[ArbiterServer]:
    """A line arbiter in a thread, with the policy of the tool."""
    machine.make_chip()
    policy = replace(arbiter_policy(load(machine.path)), min_switch_us=0)
    with ArbiterServer(VirtualLines(machine.chip), machine.socket, policy) as running:
        thread = threading.Thread(target=running.run)
        thread.start()
        try:
            yield running
        finally:
            running.stop()
            thread.join()


class Sender(threading.Thread):
    """Writes to a pty until the end of the block, at 500 Hz."""

    def __init__(self, pty: PtyPair, message: Callable[[int], bytes]) -> None:
        super().__init__()
        self._pty, self._message, self._end = pty, message, threading.Event()

    def run(self) -> None:
        number = 0
        while not self._end.wait(0.002):
            self._pty.write(self._message(number))
            number += 1

    def __enter__(self) -> Sender:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self.join()


def frame(number: int, **values: int | None) -> bytes:
    return CODEC.encode(Frame(0, number, 20 * number, {**PRESSURES, **values}))


# The whole


@pytest.mark.wall
@pytest.mark.timeout(90)
def test_a_running_tool_is_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    with World(load(profile_path()), "nominal", tmp_path) as world:
        arguments = [str(world.description_path), "--json"]
        result = CliRunner().invoke(_doctor.command, arguments, catch_exceptions=False)
        told = json.loads(result.stdout)
        assert (result.exit_code, told["ok"], told["exit_code"]) == (0, True, 0), result.stdout
        of: dict[str, list[dict[str, str]]] = {}
        for each in told["findings"]:
            of.setdefault(each["part"], []).append(each)
        assert list(of) == list(_doctor.PARTS)
        (lines,), (arbiter, active), (link,) = of["lines"], of["arbiter"], of["link"]
        assert lines["what"].endswith(
            f"active: none; held by pid {world_arbiter(world)} ({owner_words(world)})"
        )
        assert arbiter["what"] == f"pid {world_arbiter(world)} serves {world.socket}; no program writes"
        assert active["what"] == "active: no line"
        assert link["what"].startswith(f"{world.port}, ees1-ascii, 115200 baud: 50 frames, ")
        assert 35 <= int(link["what"].split(", ")[-1].split()[0]) <= 60
        assert [each["status"] for each in (*of["lines"], *of["arbiter"], *of["link"])] == ["ok"] * 4
        # nothing was requested: the lines are as the arbiter adopted them
        assert set(read_chip(world.chip).lines.values()) == {("out", False)}


def world_arbiter(world: World) -> int:
    (holder,) = holders_of(f"{world.chip}.lock")
    return holder.pid


def owner_words(world: World) -> str:
    return holders_of(f"{world.chip}.lock")[0].program


def test_nothing_is_there(machine: Machine) -> None:
    result = machine.doctor()
    assert result.exit_code == 3
    lines = result.stdout.splitlines()
    missing = [line.split(maxsplit=2) for line in lines if line.startswith("missing")]
    assert [words[1] for words in missing] == ["lines", "arbiter", "link"]
    assert missing[0][2] == f"{machine.chip}: there is no virtual chip: No such file or directory."
    assert missing[1][2] == f"no line arbiter runs at {machine.socket}"
    assert missing[2][2] == f"{machine.port} does not exist"
    assert all(lines[i + 1].strip().startswith("→ ") for i, line in enumerate(lines) if line[:7] == "missing")
    assert sorted(path.name for path in machine.path.parent.iterdir()) == ["tool.yaml"]


@pytest.mark.parametrize("text", ["", "name: [", "\0", "name: x\nlink: {port: /dev/null}\n"])
def test_a_bad_description_is_2_and_the_rest_is_looked_at(machine: Machine, text: str) -> None:
    machine.path.write_text(text)
    result = machine.doctor("--json")
    told = json.loads(result.stdout)
    assert (result.exit_code, told["exit_code"]) == (2, 2)
    parts = [each["part"] for each in told["findings"]]
    assert set(parts) == {"python", "description", "ros", "machine"}
    assert all(
        str(machine.path) in each["what"] for each in told["findings"] if each["part"] == "description"
    )


def test_a_description_is_a_file(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.yaml"):
        assert CliRunner().invoke(_doctor.command, [str(path)], catch_exceptions=False).exit_code == 2


def test_what_does_not_fit_the_codec_is_told(machine: Machine) -> None:
    machine.describe("ees1-asci")
    ((level, what, _),) = machine.findings("description")
    assert (level, "there is no such codec" in what, "did you mean" in what) == ("missing", True, True)


def test_only_what_was_asked_for(machine: Machine) -> None:
    machine.make_chip()
    result = machine.doctor("--only", "lines, machine")
    assert result.exit_code == 0
    assert {line.split()[1] for line in result.stdout.splitlines() if line[:1].isalpha()} == {
        "lines",
        "machine",
    }
    refused = CliRunner().invoke(_doctor.command, [str(machine.path), "--only", "line"])
    assert (refused.exit_code, "there are python, description, ros" in refused.output) == (2, True)


def test_never_a_traceback(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks() -> Iterator[CheckResult]:
        raise ZeroDivisionError

    monkeypatch.setattr(_ros, "look_at_ros", breaks)
    assert machine.finding("ros") == (
        "missing",
        "it could not be looked at: ZeroDivisionError: no reason given",
        "Please report this.",
    )


# Lines


def test_a_chip_of_another_tool(machine: Machine) -> None:
    VirtualChip.create(machine.chip, [name.replace("MM_208", "M_208") for name in LINES])
    level, what, _ = machine.finding("lines")
    assert (level, what) == (
        "missing",
        f"{machine.chip} has no line SODIMM_208 (did you mean 'SODIM_208'?)",
    )


def test_what_is_active_is_told_and_stays_so(machine: Machine) -> None:
    machine.make_chip()
    lines = VirtualLines(machine.chip)
    lines.request(LINES)
    lines.set({"SODIMM_208": True})
    lines.close()
    before = machine.chip.read_bytes()
    assert machine.finding("lines")[:2] == (
        "ok",
        f"virtual chip {machine.chip}; active: SODIMM_208; held by nobody",
    )
    assert machine.chip.read_bytes() == before


class Kernel:
    """What the doctor asks of gpiod 2; a request is not among it."""

    api_version = "2.3"

    def __init__(self, **chips: list[SimpleNamespace] | OSError) -> None:
        self._chips = chips

    def is_gpiochip_device(self, path: str) -> bool:
        return Path(path).name in self._chips

    def Chip(self, path: str) -> Any:
        lines = self._chips[Path(path).name]
        if isinstance(lines, OSError):
            raise lines

        class Chip:
            def __enter__(self) -> Chip:
                return self

            def __exit__(self, *_: object) -> None:
                pass

            def get_info(self) -> SimpleNamespace:
                return SimpleNamespace(num_lines=len(lines))

            def get_line_info(self, offset: int) -> SimpleNamespace:
                return lines[offset]

        return Chip()


def gpio(name: str, consumer: str | None = None, *, used: bool = False) -> SimpleNamespace:
    return SimpleNamespace(
        name=name, used=used or bool(consumer), consumer=consumer, direction="Direction.OUTPUT"
    )


def look_at(kernel: object, folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setitem(sys.modules, "gpiod", kernel)  # type: ignore[arg-type]
    found = _lines.look_at_lines(load(profile_path()), LINES, f"{folder}/chip*")
    return [f"{finding.level.value}: {finding.what}" for finding in found]


def test_lines_of_the_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("chip0", "chip1", "chip2", "chip3"):
        (tmp_path / name).touch()
    kernel = Kernel(
        chip0=[gpio("SODIMM_206"), gpio(""), gpio("SODIMM_208", "end-effector-hal")],
        chip1=[gpio("SODIMM_206"), gpio("SODIMM_210", "wifi"), gpio("SODIMM_21")],
        chip2=PermissionError(13, "Permission denied"),
        chip3=OSError(19, "No such device"),
    )
    assert look_at(kernel, tmp_path, monkeypatch) == [
        f"missing: {tmp_path}/chip2 may not be opened: permission denied",
        f"missing: {tmp_path}/chip3 cannot be opened: No such device",
        "missing: no line SODIMM_212 (did you mean 'SODIMM_21'?) on "
        + ", ".join(f"{tmp_path}/chip{number}" for number in range(4)),
        f"ok: SODIMM_208 = {tmp_path}/chip0 line 2, output, held by the line arbiter",
        f"missing: SODIMM_210 = {tmp_path}/chip1 line 1 is held by wifi",
        f"missing: SODIMM_206 is ambiguous: {tmp_path}/chip0 line 0 and {tmp_path}/chip1 line 0",
    ]


def test_no_chip_and_the_wrong_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert look_at(Kernel(), tmp_path, monkeypatch) == [
        f"missing: there is no GPIO chip here ({tmp_path}/chip*)"
    ]
    debian = SimpleNamespace(__version__="1.6.3")
    assert look_at(debian, tmp_path, monkeypatch) == ["missing: gpiod has the API 1, needed is 2"]
    assert look_at(None, tmp_path, monkeypatch)[0].startswith("missing: gpiod cannot be imported: ")


# Arbiter


def test_an_arbiter_and_its_clients(machine: Machine, arbiter: ArbiterServer) -> None:
    from end_effector_hal.arbiter import ArbiterClient

    proven = proving(machine.socket, locked=True, nothing_gripped=False, parked=True)
    machine.findings("arbiter")  # the first look takes longer than what is said counts
    with ArbiterClient(machine.socket, "grip", ["SODIMM_208"]) as client, proven:
        client.set({"SODIMM_208": True}, will=[("SODIMM_208", False, 0)])
        assert machine.findings("arbiter") == [
            (
                "ok",
                f"pid {os.getpid()} serves {machine.socket}; writing: grip (pid {os.getpid()})",
                "",
            ),
            ("ok", "active: SODIMM_208 (bottom_vacuum)", ""),
            ("ok", "by the sensors: locked yes, nothing_gripped no, parked yes", ""),
        ]
        assert client.levels()["SODIMM_208"], "a look is not a death"


def test_an_arbiter_that_nobody_tells_of_the_sensors_and_its_faults(
    machine: Machine, arbiter: ArbiterServer
) -> None:
    from end_effector_hal.arbiter import ArbiterClient

    with ArbiterClient(machine.socket, "grip", ["SODIMM_208"]) as client:
        client.latch("sensor_fault", "IL-04: both bits are set.")
        told = machine.findings("arbiter")[2:]
    assert [level for level, _, _ in told] == ["warning", "warning"]
    assert (
        told[0][1]
        == "no process reports what the sensors show (locked, nothing_gripped, parked): activations are refused"
    )
    assert told[1][1] == "latched: IL-04: both bits are set."


def test_the_arbiter_of_another_tool(machine: Machine, arbiter: ArbiterServer) -> None:
    text = machine.path.read_text().replace("SODIMM_212", "SODIMM_216")
    machine.describe(text=text)
    level, what, todo = machine.finding("arbiter")
    assert (level, what) == (
        "missing",
        f"pid {os.getpid()} at {machine.socket} owns other lines: {', '.join(LINES)}",
    )
    assert "another description" in todo


@pytest.mark.wall
def test_an_arbiter_that_hangs_is_named(machine: Machine) -> None:
    machine.make_chip()
    with subprocess.Popen([*EEHAL, "arbiter", str(machine.path)], stdout=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stdout.readline().startswith(b"ready:")
        try:
            process.send_signal(signal.SIGSTOP)
            level, what, todo = machine.finding("arbiter")
        finally:
            process.kill()
    assert level == "missing"
    assert what.startswith(f"{machine.socket} is held by pid {process.pid} (")
    assert what.endswith("): the line arbiter does not answer.")
    assert "adopts" in todo
    # a socket that a dead arbiter left behind
    assert machine.finding("arbiter")[:2] == ("missing", f"no line arbiter runs at {machine.socket}")


def test_an_arbiter_where_somebody_else_put_it(
    machine: Machine, arbiter: ArbiterServer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:

    monkeypatch.setattr(_arbiter, "_FOLDERS", (tmp_path,))
    machine.describe(text=machine.path.read_text().replace(f"{machine.socket}", f"{tmp_path}/x/owner.sock"))
    assert machine.finding("arbiter") == (
        "missing",
        f"no line arbiter at {tmp_path}/x/owner.sock, but there is a socket at {machine.socket}",
        f"Set EEHAL_RUN_DIR={tmp_path}, like the arbiter.",
    )


STRANGER = """
import contextlib, io, sys
from end_effector_hal.cli.doctor._doctor import command
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    command(["/dev/stdin", *sys.argv[1:]])  # as root: whatever it takes to look is loaded by this
become_nobody(groups)
command(["/dev/stdin", *sys.argv[1:]])
"""


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
def test_a_stranger_is_told_which_group_he_needs() -> None:
    def told() -> list[tuple[str, str]]:
        # the description is open already: a stranger to the wires, not to the disk
        with machine.path.open() as description:
            result = as_nobody(STRANGER, "--json", "--only", "lines,arbiter,link", stdin=description)
        assert (result.returncode, result.stderr) == (3, "")
        return [(each["what"], each["todo"]) for each in json.loads(result.stdout)["findings"]]

    with TemporaryDirectory(dir="/tmp") as name:
        folder = Path(name)
        folder.chmod(0o711)
        machine = Machine(folder)
        with serving(machine), PtyPair(machine.port):
            lines, socket, port = told()
            assert lines[0].endswith("it may not be written")
            assert socket[0] == f"{machine.socket} may not be opened: permission denied"
            assert "group gpio" in socket[1]
            assert port[0] == f"{machine.port} may not be opened: permission denied"
            assert "group dialout" in port[1]
            folder.chmod(0o700)
            assert told()[1][0] == f"{folder} may not be entered: permission denied"


# Link


def test_frames_are_heard(machine: Machine) -> None:
    with PtyPair(machine.port) as pty, Sender(pty, frame):
        level, what, todo = machine.finding("link")
    assert (level, todo) == ("ok", "")
    assert what.startswith(f"{machine.port}, ees1-ascii, 115200 baud: ")


def test_what_is_wrong_with_the_frames_is_told(machine: Machine) -> None:
    def message(number: int) -> bytes:
        whole = frame(2 * number, top=None)
        return whole.replace(b"$EES1", b"$EES2") if number % 5 == 4 else whole

    with PtyPair(machine.port) as pty, Sender(pty, message):
        level, what, todo = machine.finding("link")
    assert level == "warning"
    assert " lost, " in what
    assert " format, no value of top" in what
    assert todo


def test_a_channel_that_the_tool_does_not_use_is_no_matter(machine: Machine) -> None:
    text = machine.path.read_text().replace("cylinder, top_vacuum]", "cylinder]")
    start, end = text.index("  top_vacuum:\n"), text.index("tool_changer:\n")
    machine.describe(text=text[:start] + text[end:])
    with PtyPair(machine.port) as pty, Sender(pty, lambda number: frame(number, top=None)):
        _, what, _ = machine.finding("link")
    assert " frames" in what
    assert "no value of" not in what


def test_silence_noise_and_another_codec(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:

    monkeypatch.setattr(_link, "LISTEN_US", 200_000)
    with PtyPair(machine.port) as pty:
        assert machine.finding("link")[:2] == (
            "missing",
            f"{machine.port}, ees1-ascii, 115200 baud: silent",
        )
        with Sender(pty, lambda number: b"\xa5"):
            level, what, todo = machine.finding("link")
        assert (level, what.endswith(" bytes and no frame")) == ("missing", True)
        assert todo.startswith("Baud rate")
        with Sender(pty, lambda number: b"\x05"):
            assert machine.finding("link")[2] == "Set link.codec: legacy-nibble."


@pytest.mark.parametrize("program", ["eehal-like", "other"])
def test_a_reader_loses_no_byte(machine: Machine, program: str, tmp_path: Path) -> None:
    script = tmp_path / program
    script.write_text(
        "import os, select, sys\n"
        "fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
        "print('open', flush=True)\n"
        "data = b''\n"
        "while not data.endswith(b'!') and select.select([fd], [], [], 5)[0]:\n"
        "    data += os.read(fd, 4096)\n"
        "print(data.decode(), flush=True)\n"
    )
    with (
        PtyPair(machine.port) as pty,
        subprocess.Popen(
            [sys.executable, str(script), str(machine.port)], stdout=subprocess.PIPE, text=True
        ) as reader,
    ):
        assert reader.stdout
        assert reader.stdout.readline() == "open\n"
        pty.write(b"abc")
        started = time.monotonic()
        level, what, _ = machine.finding("link")
        assert time.monotonic() - started < 1.5, "it listened"
        pty.write(b"def!")
        assert reader.stdout.readline() == "abcdef!\n"
    called = f"{program} {machine.port}"
    called = called if len(called) <= 80 else f"{called[:79]}…"
    assert (
        what
        == f"{machine.port} is read by pid {reader.pid} ({called}); not listened to, its bytes are theirs"
    )
    assert level == ("ok" if program == "eehal-like" else "warning")


def test_a_passive_look_opens_nothing(machine: Machine) -> None:
    with PtyPair(machine.port) as pty:
        pty.write(b"abc")
        assert machine.finding("link", "--passive")[:2] == (
            "ok",
            f"{machine.port} is there and nobody reads it; not listened to",
        )


def test_ports_that_are_none(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    machine.port.symlink_to("/dev/pts/99999")
    assert machine.finding("link")[1] == f"{machine.port} leads to /dev/pts/99999, which is not there"
    machine.port.unlink()
    machine.port.touch()
    assert machine.finding("link")[1] == f"{machine.port}: this is not a serial port."
    of_all = os.access
    monkeypatch.setattr(os, "access", lambda path, *more: path != machine.port and of_all(path, *more))
    assert machine.finding("link")[1] == f"{machine.port} may not be opened: permission denied"
    assert "dialout" in machine.finding("link")[2]


# ROS


class Master:
    """What a ROS master and its nodes answer, on a loopback port."""

    def __init__(self, nodes: dict[str, bool]) -> None:
        self._server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False, allow_none=True)
        self.uri = f"http://127.0.0.1:{self._server.server_address[1]}"
        published = [["/x", [name]] for name in nodes]
        self._server.register_function(lambda caller: [1, "", 4711], "getPid")
        self._server.register_function(lambda caller: [1, "", [published, [], []]], "getSystemState")
        self._server.register_function(
            lambda caller, name: [1, "", self.uri if nodes[name] else "http://127.0.0.1:9"], "lookupNode"
        )
        self._thread = threading.Thread(target=self._server.serve_forever)

    def __enter__(self) -> Master:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


HAL = ("HALMain", "Grip", "ToolChange", "Pressure", "Position")


@pytest.mark.parametrize(
    ("nodes", "expected"),
    [
        (dict.fromkeys(["/cell/" + name for name in HAL], True), "ok: nodes " + ", ".join(HAL) + " answer"),
        (
            {**dict.fromkeys(["/" + name for name in HAL], True), "/Grip": False},
            "missing: nodes that do not answer: Grip",
        ),
        ({"/rosout": True}, "missing: none of the HAL's nodes runs"),
    ],
)
def test_master_and_nodes(
    machine: Machine, monkeypatch: pytest.MonkeyPatch, nodes: dict[str, bool], expected: str
) -> None:
    with Master(nodes) as master:
        monkeypatch.setenv("ROS_MASTER_URI", master.uri)
        *_, at, last = machine.findings("ros")
    assert at[:2] == ("ok", f"master at {master.uri} (pid 4711)")
    assert f"{last[0]}: {last[1]}" == expected


@pytest.mark.parametrize("uri", ["http://127.0.0.1:9", "nonsense", "", "http://127.0.0.1:x"])
def test_no_master(machine: Machine, monkeypatch: pytest.MonkeyPatch, uri: str) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    assert machine.findings("ros")[-1][0] == "missing"


def test_without_ros_the_tool_runs(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_ros, "PACKAGES", ("rospy", "no_such_package"))
    absent, *_ = machine.findings("ros")
    assert (absent[0], "no_such_package" in absent[1]) == ("warning", True)
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    assert machine.findings("ros")[0][0] == "missing"


def test_messages_without_their_launch_files(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    class NotFound(Exception):
        pass

    class RosPack:
        def get_path(self, name: str) -> str:
            raise NotFound(name)

    stand_in = SimpleNamespace(RosPack=RosPack, ResourceNotFound=NotFound)
    monkeypatch.setitem(sys.modules, "rospkg", stand_in)  # type: ignore[arg-type]
    monkeypatch.setattr(_ros, "_there", lambda name: True)
    what = "end_effector_msgs are built; roslaunch does not find end_effector_hal"
    assert ("warning", what) in [finding[:2] for finding in machine.findings("ros")]
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    assert ("missing", what) in [finding[:2] for finding in machine.findings("ros")]


# Machine


def test_hints_about_time() -> None:
    def told(finding: CheckResult) -> tuple[Level, str]:
        return finding.level, finding.what

    assert told(_machine.kernel("#1 SMP PREEMPT_DYNAMIC x", realtime=False))[0] is Level.OK
    assert told(_machine.kernel("#1 SMP PREEMPT_RT x", realtime=False)) == (
        Level.OK,
        "kernel with PREEMPT_RT",
    )
    assert told(_machine.kernel("#1 SMP x", realtime=False))[0] is Level.WARNING
    assert told(_machine.load(2.0, 2)) == (Level.OK, "load 2.0 on 2 processors")
    assert told(_machine.load(1.1, 1))[0] is Level.WARNING
    assert told(_machine.lateness(25_000, 50_000))[0] is Level.OK
    assert told(_machine.lateness(25_001, 50_000))[0] is Level.WARNING
    assert told(_machine.lateness(99_000, None))[0] is Level.OK


def test_the_reaction_bound_is_that_of_the_description(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_machine, "worst_wake_up_us", lambda: 7_000)
    text = machine.path.read_text()
    machine.describe(text=text.replace("reaction_ms: 50", "reaction_ms: 10"))
    assert machine.findings("machine")[-1][:2] == (
        "warning",
        "worst of 50 wake-ups 7.0 ms late; the reaction bound is 10 ms",
    )


def test_the_shipped_description_is_the_default() -> None:
    result = CliRunner().invoke(_doctor.command, ["--only", "description"], catch_exceptions=False)
    description: Description = load(profile_path())
    assert result.stdout == (
        f"ok       description  {profile_path()}: {description.name} ({description.fingerprint()})\n"
    )
