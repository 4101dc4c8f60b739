"""Every command of ``eehal`` with closed standard streams: its input is empty, its output cannot be written."""

from __future__ import annotations

import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import load, profile_path, socket_path
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from end_effector_lab.testbench import write_description
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.refuted import REFUTED

pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]
LOST = "The output cannot be written: Bad file descriptor."
PRINTING = (
    "--help", "--version", "check {tool}", "devices", "doctor {tool}", "init {new}", "listen {tool} --seconds 1",
    "model check {model}", "plugin list", "reset {tool}", "run {tool}", "run {tool} --script status", "schema",
    "stop {tool}", "verify --model {model}",
)  # fmt: skip
"""Commands that end by themselves and print."""


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    folder = tmp_path_factory.mktemp("streams")
    (folder / "model.xml").write_text(REFUTED)
    with World(load(profile_path()), "nominal", folder) as world:
        other = world.description.with_virtual(folder / "chip", str(folder / "uart"), folder / "socket")
        write_description(other, folder / "other.yaml", "the same tool elsewhere")
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        files = {"model": folder / "model.xml", "new": folder / "new", "other": folder / "other.yaml"}
        named = {name: str(path) for name, path in files.items()}
        yield {**named, "tool": str(world.description_path), "folder": str(folder), "port": str(port)}


def closed(words: str, names: dict[str, str], streams: str) -> subprocess.Popen[str]:
    command = ["sh", "-c", f'exec "$@" {streams}', "sh", *EEHAL, *words.format_map(names).split()]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


@pytest.mark.parametrize("words", PRINTING)
def test_a_command_whose_output_is_lost_says_so(words: str, names: dict[str, str]) -> None:
    with closed(words, names, "<&- >&-") as process:
        said = process.communicate(timeout=PATIENCE_S)[1].splitlines()
    assert (process.returncode, said[-1]) == (2, LOST)
    assert len(said) == (2 if words == "run {tool}" else 1), said
    if words == "stop {tool}":
        with ArbiterClient(socket_path(load(Path(names["tool"]))), "test", patience_s=0) as arbiter:
            assert arbiter.status()["faults"], "it is carried out"


def test_a_command_that_prints_nothing_ends_as_ever(names: dict[str, str]) -> None:
    with closed("reload {tool}", names, "<&- >&-") as process:
        assert LOST not in process.communicate(timeout=PATIENCE_S)[1]
    assert process.returncode == 3, "the program of the tool does not run"


def test_without_standard_error_as_well(names: dict[str, str]) -> None:
    for words in ("--help", "run {tool} --script status"):
        with closed(words, names, "<&- >&- 2>&-") as process:
            assert process.wait(PATIENCE_S) == 2


def test_what_serves_does_so_until_a_signal(names: dict[str, str]) -> None:
    folder = Path(names["folder"])
    with (
        closed("page {tool} --port {port}", names, "<&- >&-") as page,
        closed("testbench {other}", names, "<&- >&-") as testbench,
    ):
        wait_until("the testbench works", (folder / "uart").exists)
        with closed("arbiter {other}", names, "<&- >&-") as arbiter:
            wait_until("the arbiter works", (folder / "socket").exists)
            wait_until("the page works", lambda: answers(int(names["port"])))
            for process in (arbiter, testbench, page):
                process.send_signal(signal.SIGTERM)
                assert "Traceback" not in process.communicate(timeout=PATIENCE_S)[1]
                assert process.returncode in (0, -signal.SIGTERM)


def answers(port: int) -> bool:
    with socket.socket() as client:
        return client.connect_ex(("127.0.0.1", port)) == 0
