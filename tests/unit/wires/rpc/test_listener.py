"""A client for which there is no file is turned away; nothing spins, and the log has it once."""

from __future__ import annotations

import os
import resource
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp

import pytest

from end_effector_hal.wires.rpc import ClientLimits, Listener, Server


@contextmanager
def no_files_left() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    lowest = os.dup(0)
    os.close(lowest)  # the next one would get this number
    resource.setrlimit(resource.RLIMIT_NOFILE, (lowest, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.fixture
def path() -> Path:
    return Path(mkdtemp(prefix="eehal-listener-")) / "a.sock"


def connected(path: Path) -> socket.socket:
    client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    client.connect(str(path))
    client.settimeout(5)
    return client


def test_without_files_a_client_is_turned_away_and_nobody_waits(
    path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    listener = Listener(path)
    waiting = [connected(path) for _ in range(3)]
    with no_files_left():
        assert [listener.accept() for _ in waiting] == [None] * 3
        assert [client.recv(1) for client in waiting] == [b""] * 3
        assert listener.accept() is None, "nobody waits any more"
    assert [each.message for each in caplog.records] == [
        f"{path}: a client is turned away: Too many open files"
    ]
    again = connected(path)
    accepted = listener.accept()
    assert accepted is not None
    accepted.sendall(b"x")
    assert again.recv(1) == b"x"
    for each in (*waiting, again, accepted):
        each.close()
    listener.close()


def test_a_server_without_files_serves_the_clients_that_it_has(path: Path) -> None:
    server = Server(path, ClientLimits(backlog=0))
    first = connected(path)
    server.poll()
    second = connected(path)
    with no_files_left():
        server.poll()
        assert second.recv(1) == b""
        server.send(b"record")
    assert first.recv(6) == b"record"
    for each in (first, second):
        each.close()
    server.close()


def test_a_socket_that_cannot_take_its_place_leaves_nothing_behind(path: Path) -> None:
    path.mkdir()
    with pytest.raises(Exception, match="cannot be made"):
        Listener(path)
    assert list(path.parent.iterdir()) == [path]


def test_the_socket_is_removed_unless_another_server_has_taken_its_place(tmp_path: Path) -> None:
    path = tmp_path / "socket"
    first, second = Listener(path), Listener(path)
    first.close()
    assert path.exists()
    second.close()
    assert not path.exists()
