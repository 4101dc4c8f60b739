"""Who comes where there is no file for them is sent away; nothing spins, and the log says it once."""

from __future__ import annotations

import os
import resource
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp

import pytest

from end_effector_hal.wires import Acceptor, RelayServer, listen


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
    return Path(mkdtemp(prefix="eehal-acceptor-")) / "a.sock"


def connected(path: Path) -> socket.socket:
    client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    client.connect(str(path))
    client.settimeout(5)
    return client


def test_without_files_a_client_is_sent_away_and_nobody_waits(
    path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    acceptor = Acceptor(listen(path), "the relay")
    waiting = [connected(path) for _ in range(3)]
    with no_files_left():
        assert [acceptor.accept() for _ in waiting] == [None] * 3
        assert [client.recv(1) for client in waiting] == [b""] * 3
        assert acceptor.accept() is None, "nobody waits any more"
    assert [each.message for each in caplog.records] == [
        "the relay: a client is sent away: Too many open files"
    ]
    again = connected(path)
    accepted = acceptor.accept()
    assert accepted is not None
    accepted.sendall(b"x")
    assert again.recv(1) == b"x"
    for each in (*waiting, again, accepted):
        each.close()
    acceptor.close()


def test_a_relay_without_files_serves_those_whom_it_has(path: Path) -> None:
    relay = RelayServer(path)
    first = connected(path)
    relay.ready(relay.sockets[0])
    second = connected(path)
    with no_files_left():
        relay.ready(relay.sockets[0])
        assert second.recv(1) == b""
        relay.send(b"record")
    assert first.recv(6) == b"record"
    for each in (first, second):
        each.close()
    relay.close()


def test_a_socket_that_cannot_take_its_place_leaves_nothing_behind(path: Path) -> None:
    path.mkdir()
    with pytest.raises(Exception, match="cannot be made"):
        listen(path)
    assert list(path.parent.iterdir()) == [path]


def test_the_socket_is_removed_unless_somebody_else_has_taken_its_place(tmp_path: Path) -> None:
    path = tmp_path / "socket"
    first = Acceptor(listen(path), "first", path)
    second = Acceptor(listen(path), "second", path)
    first.close()
    assert path.exists()
    second.close()
    assert not path.exists()
