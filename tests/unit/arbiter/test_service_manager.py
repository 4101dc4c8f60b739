"""What the line arbiter tells systemd, held against a stand-in that listens on its socket."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient, ArbiterServer, Policy
from end_effector_hal.arbiter._process import _Probe
from end_effector_hal.arbiter._service_manager import ServiceManager
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ArbiterError, LineBusyError
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S
from tests.support.proving import proving
from tests.support.stopped import stop


class Manager:
    """Systemd's end of NOTIFY_SOCKET, with its descriptor store."""

    def __init__(self, address: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(address)
        self.store: dict[str, int] = {}

    def told(self, within_s: float = PATIENCE_S) -> str:
        """The next message that is not for the store; "" if none comes."""
        self._socket.settimeout(within_s)
        try:
            message, descriptors, _, _ = socket.recv_fds(self._socket, 4096, 8)
        except TimeoutError:
            return ""
        fields = dict(line.split("=", 1) for line in message.decode().splitlines())
        if "FDSTOREREMOVE" in fields:
            self._forget(fields["FDNAME"])
        elif "FDSTORE" in fields:
            (self.store[fields["FDNAME"]],) = descriptors
        else:
            assert not descriptors
            return message.decode()
        return self.told(within_s)

    @contextmanager
    def start(self, command: list[str], environ: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
        """As systemd starts a service again: what is stored stands from descriptor 3 on; killed in the end."""
        given = [*self.store.values()]
        words = [sys.executable, "-c", EXECUTE, ",".join(map(str, given)), ":".join(self.store), *command]
        process = subprocess.Popen(words, env=environ, stdout=subprocess.DEVNULL, pass_fds=given)
        try:
            yield process
            process.wait(PATIENCE_S)
        finally:
            process.kill()
            process.wait()

    def close(self) -> None:
        self._socket.close()
        for name in list(self.store):
            self._forget(name)

    def _forget(self, name: str) -> None:
        if name in self.store:
            os.close(self.store.pop(name))


EXECUTE = """
import os, sys
given, names, *command = sys.argv[1:]
moved = [os.dup2(int(fd), 100 + i) for i, fd in enumerate(filter(None, given.split(",")))]
for i, fd in enumerate(moved):
    os.dup2(fd, 3 + i, inheritable=True)
os.closerange(3 + len(moved), 200)
told = {"LISTEN_PID": str(os.getpid()), "LISTEN_FDS": str(len(moved)), "LISTEN_FDNAMES": names}
os.execve(command[0], command, {**os.environ, **told})
"""


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[Manager]:
    running = Manager(str(tmp_path / "notify"))
    yield running
    running.close()


def test_it_is_told_when_it_is_ready_and_no_more(manager: Manager, tmp_path: Path) -> None:
    with ServiceManager({"NOTIFY_SOCKET": str(tmp_path / "notify")}) as program:
        program.ready("all is\nwell", lambda: pytest.fail("nobody asked for a watchdog"))
    assert manager.told() == "READY=1\nSTATUS=all is well"
    assert manager.told(0.1) == ""


def test_a_name_in_the_abstract_namespace() -> None:
    name = f"eehal-test-{os.getpid()}"
    manager = Manager(f"\0{name}")
    ServiceManager({"NOTIFY_SOCKET": f"@{name}"}).ready("", lambda: None)
    assert manager.told().startswith("READY=1\n")
    manager.close()


@pytest.mark.parametrize("environ", [{}, {"NOTIFY_SOCKET": "/nowhere"}, {"WATCHDOG_USEC": "1000"}])
def test_without_a_manager_it_runs_all_the_same(environ: dict[str, str]) -> None:
    with ServiceManager(environ) as program:
        program.ready("", lambda: None)


@pytest.mark.parametrize("own", [True, False])
def test_signs_of_life_stop_when_it_does_not_answer(manager: Manager, tmp_path: Path, *, own: bool) -> None:
    asked: list[int] = []

    def alive() -> None:
        asked.append(1)
        if len(asked) > 2:
            raise ArbiterError("it does not answer.")

    pid = str(os.getpid()) if own else ""
    environ = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "30000", "WATCHDOG_PID": pid}
    with ServiceManager(environ) as program:
        program.ready("", alive)
        assert [manager.told() for _ in range(3)] == ["READY=1\nSTATUS=", "WATCHDOG=1", "WATCHDOG=1"]
        assert manager.told(0.2) == ""
    assert len(asked) > 2


def test_the_watchdog_of_another_process(manager: Manager, tmp_path: Path) -> None:
    environ = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "1000", "WATCHDOG_PID": "1"}
    with ServiceManager(environ) as program:
        program.ready("", lambda: None)
        assert manager.told().startswith("READY=1")
        assert manager.told(0.1) == ""


def virtual_tool(folder: Path) -> Path:
    """The shipped tool on a virtual chip, with its socket beside it."""
    description = folder / "tool.yaml"
    virtual = f"backend: virtual\n  path: {folder}/chip\n  socket: {folder}/arbiter.sock\n"
    description.write_text(profile_path().read_text().replace("backend: gpiod", virtual))
    VirtualChip.create(folder / "chip", load(profile_path()).output_lines)
    return description


def test_what_was_handed_on_is_for_this_process_and_has_a_name(tmp_path: Path) -> None:
    ours = {"LISTEN_PID": str(os.getpid()), "LISTEN_FDS": "0", "LISTEN_FDNAMES": ""}
    assert ServiceManager(ours).stored_descriptors() == {}
    assert ServiceManager({"LISTEN_PID": "1", "LISTEN_FDS": "5"}).stored_descriptors() == {}
    assert ServiceManager({}).stored_descriptors() == {}


@pytest.mark.wall
def test_lines_are_handed_on_without_a_gap(manager: Manager, tmp_path: Path) -> None:
    description, chip = virtual_tool(tmp_path), tmp_path / "chip"
    environ = {**os.environ, "NOTIFY_SOCKET": str(tmp_path / "notify")}
    command = [*EEHAL, "arbiter", str(description)]
    with manager.start(command, environ) as first:
        assert manager.told().startswith("READY=1")
        assert list(manager.store) == ["virtual-chip"]
        client = ArbiterClient(tmp_path / "arbiter.sock", "grip", ["SODIMM_208"])
        with proving(tmp_path / "arbiter.sock", locked=True):
            client.set({"SODIMM_208": True}, [])
        while not client.levels()["SODIMM_208"]:
            time.sleep(0.01)
        first.kill()
    records = chip.read_bytes()
    # while there is no arbiter nobody else can take the lines
    with pytest.raises(LineBusyError, match="the virtual chip is held by"):
        VirtualLines(chip).request(["SODIMM_208"])
    for signal_number in (signal.SIGTERM, signal.SIGKILL):
        with manager.start(command, environ) as second:
            assert manager.told().startswith("READY=1")
            assert list(manager.store) == ["virtual-chip"]
            with ArbiterClient(tmp_path / "arbiter.sock", "look") as look:
                assert look.levels()["SODIMM_208"]
            second.send_signal(signal_number)
    assert chip.read_bytes() == records, "no line was written"
    client.close()
    # a service that is stopped for good gives everything back
    manager.close()
    lines = VirtualLines(chip)
    assert lines.request(["SODIMM_208"])["SODIMM_208"]
    lines.close()


@pytest.mark.wall
def test_what_was_handed_on_and_fits_nothing_is_given_back(manager: Manager, tmp_path: Path) -> None:
    description, elsewhere = virtual_tool(tmp_path), tmp_path / "elsewhere"
    VirtualChip.create(elsewhere, ["A"])
    stranger = VirtualLines(elsewhere)
    stranger.request(["A"])
    manager.store = {
        name: os.dup(stranger.descriptors()["virtual-chip"]) for name in ("virtual-chip", "other")
    }
    stranger.close()
    environ = {**os.environ, "NOTIFY_SOCKET": str(tmp_path / "notify")}
    with manager.start([*EEHAL, "arbiter", str(description)], environ) as arbiter:
        assert manager.told().startswith("READY=1")
        os.close(manager.store.pop("other"))
        again = VirtualLines(elsewhere)
        again.request(["A"])
        again.close()
        arbiter.terminate()


@pytest.mark.wall
def test_a_stopped_arbiter_gives_no_sign_of_life(manager: Manager, tmp_path: Path) -> None:
    description = virtual_tool(tmp_path)
    environ = {**os.environ, "NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "150000"}
    environ.pop("WATCHDOG_PID", None)
    with manager.start([*EEHAL, "arbiter", str(description)], environ) as arbiter:
        assert manager.told() == f"READY=1\nSTATUS=verdin_gripper on {tmp_path}/arbiter.sock"
        assert manager.told() == "WATCHDOG=1"
        stop(arbiter.pid)
        while manager.told(0.5):
            pass
        arbiter.send_signal(signal.SIGCONT)
        assert manager.told() == "WATCHDOG=1"
        arbiter.terminate()
        assert arbiter.wait(PATIENCE_S) == 0


def test_an_arbiter_whose_loop_hangs_does_not_live(tmp_path: Path) -> None:
    VirtualChip.create(tmp_path / "chip", ["A"])
    question = _Probe(tmp_path / "arbiter.sock")
    with ArbiterServer(VirtualLines(tmp_path / "chip"), tmp_path / "arbiter.sock", Policy(["A"])) as arbiter:
        with pytest.raises(ArbiterError, match="does not answer"):
            question()
        thread = threading.Thread(target=arbiter.run)
        thread.start()
        question()
        assert question._client
        question._client.close()
        arbiter.stop()
        thread.join()
