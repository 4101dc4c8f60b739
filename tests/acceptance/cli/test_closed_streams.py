"""Every command of ``eehal`` with standard streams that are closed: it does what it does with an empty file there."""

from __future__ import annotations

import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from end_effector_lab.testbench import write_description
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.refuted import REFUTED

pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]
ENDING = {
    "--help": 0, "check {tool}": 0, "doctor {tool}": 3, "init {new}": 0, "listen {tool} --seconds 1": 0,
    "model check {model}": 0, "reload {tool}": 3, "reset {tool}": 0, "run {tool}": 0, "run {tool} --script status": 0,
    "stop {tool}": 0, "testbench --list": 0, "verify --model {model}": 4,
}  # fmt: skip
"""Commands that end by themselves, with their exit code; doctor and reload miss the program of the tool."""


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


@pytest.mark.parametrize("words", ENDING)
def test_a_command_ends_as_it_does_with_empty_streams(words: str, names: dict[str, str]) -> None:
    with closed(words, names, "<&- >&-") as process:
        said = process.communicate(timeout=PATIENCE_S)[1]
    assert "Traceback" not in said
    assert process.returncode == ENDING[words], said
    if words == "run {tool}":
        assert said.startswith("Standard input ended before the first command.")


def test_without_standard_error_as_well(names: dict[str, str]) -> None:
    for words in ("--help", "run {tool} --script status"):
        with closed(words, names, "<&- >&- 2>&-") as process:
            assert process.wait(PATIENCE_S) == 0


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
