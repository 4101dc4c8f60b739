"""What the line owner tells systemd, held against a stand-in that listens on its socket."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.demo._world import EEHAL
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import OwnerError
from end_effector_hal.tool import output_lines
from end_effector_hal.tool._owner import _Question
from end_effector_hal.tool._service_manager import ServiceManager
from end_effector_hal.wires import LineOwner, Policy, VirtualChip, VirtualLines


class Manager:
    """Systemd's end of NOTIFY_SOCKET."""

    def __init__(self, address: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(address)

    def told(self, within_s: float = 10.0) -> str:
        """The next message; "" if none comes."""
        self._socket.settimeout(within_s)
        try:
            return self._socket.recv(4096).decode()
        except TimeoutError:
            return ""

    def close(self) -> None:
        self._socket.close()


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


@pytest.mark.parametrize("pid", [str(os.getpid()), ""])
def test_signs_of_life_stop_when_it_does_not_answer(manager: Manager, tmp_path: Path, pid: str) -> None:
    asked: list[int] = []

    def alive() -> None:
        asked.append(1)
        if len(asked) > 2:
            raise OwnerError("it does not answer.")

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


@pytest.mark.wall
def test_a_stopped_owner_gives_no_sign_of_life(manager: Manager, tmp_path: Path) -> None:
    description = tmp_path / "tool.yaml"
    virtual = f"backend: virtual\n  path: {tmp_path}/chip\n  socket: {tmp_path}/owner.sock\n"
    description.write_text(profile_path().read_text().replace("backend: gpiod", virtual))
    VirtualChip.create(tmp_path / "chip", output_lines(load(profile_path())))
    environ = {**os.environ, "NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "150000"}
    environ.pop("WATCHDOG_PID", None)
    with subprocess.Popen(
        [*EEHAL, "owner", str(description)], env=environ, stdout=subprocess.DEVNULL
    ) as owner:
        assert manager.told() == f"READY=1\nSTATUS=verdin_gripper on {tmp_path}/owner.sock"
        assert manager.told() == "WATCHDOG=1"
        owner.send_signal(signal.SIGSTOP)
        while manager.told(0.5):
            pass
        owner.send_signal(signal.SIGCONT)
        assert manager.told() == "WATCHDOG=1"
        owner.terminate()
        assert owner.wait(10) == 0


def test_an_owner_whose_loop_hangs_does_not_live(tmp_path: Path) -> None:
    VirtualChip.create(tmp_path / "chip", ["A"])
    question = _Question(tmp_path / "owner.sock")
    with LineOwner(VirtualLines(tmp_path / "chip"), tmp_path / "owner.sock", Policy(["A"])) as owner:
        with pytest.raises(OwnerError, match="does not answer"):
            question()
        thread = threading.Thread(target=owner.run)
        thread.start()
        question()
        assert question._client
        question._client.close()
        owner.stop()
        thread.join()
