"""A question to a server: whatever listens at its socket, there is an answer and no traceback."""

from __future__ import annotations

import socket
import time
from contextlib import suppress
from pathlib import Path
from threading import Thread

import pytest

from end_effector_hal.wires.rpc import Client, ask

pytestmark = pytest.mark.wall


@pytest.mark.parametrize(
    "sent",
    [
        b"[]\n",
        b"7\n",
        b"{}\n",
        b"{broken\n",
        b"\xff\n",
        b'{"kind": "answer-to", "id": 1, "accepted": "yes"}\n',
        b"9" * 5_000_000 + b"\n",
        b"",
    ],
    ids=["list", "number", "empty", "broken", "no text", "half an answer", "endless", "nothing"],
)
def test_what_is_no_answer_is_a_sentence(tmp_path: Path, sent: bytes) -> None:
    path = tmp_path / "tool.hal"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        listening.bind(str(path))
        listening.listen()

        def serve() -> None:
            sock, _ = listening.accept()
            with sock:
                sock.recv(1000)
                with suppress(OSError):  # nobody reads the rest
                    sock.sendall(sent)

        served = Thread(target=serve)
        served.start()
        reply = ask(path, "The HAL", command="reload")
        served.join()
    assert not reply.accepted
    assert not reply.decided
    assert reply.reason.startswith("The HAL cannot be asked (")


def test_nobody_listens(tmp_path: Path) -> None:
    path = tmp_path / "tool.hal"
    reply = ask(path, "The HAL", command="reload")
    assert (reply.accepted, reply.decided) == (False, False)
    assert reply.reason == f"The HAL does not run: no process listens at {path}."


def test_a_server_that_is_silent_or_sends_other_things_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("end_effector_hal.wires.rpc._client.ANSWER_S", 0.3)
    path = tmp_path / "tool.hal"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        listening.bind(str(path))
        listening.listen()
        assert ask(path, "It").reason == f"It does not answer ({path})."

        def chatter() -> None:
            listening.accept()[0].close()  # of the silence before
            sock, _ = listening.accept()
            with sock, suppress(OSError):
                while True:
                    sock.sendall(b'{"kind": "alive", "at": 1, "content": {}}\n')
                    time.sleep(0.01)

        talking = Thread(target=chatter)
        talking.start()
        assert ask(path, "It").reason == f"It does not answer ({path})."
        talking.join()


def test_a_wait_is_aborted_by_another_thread(tmp_path: Path) -> None:
    path = tmp_path / "socket"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        listening.bind(str(path))
        listening.listen()
        client = Client(path, None)
        client.connect()
        errors: list[str] = []

        def wait() -> None:
            try:
                client.receive()
            except OSError as error:
                errors.append(str(error))

        waiting = Thread(target=wait)
        waiting.start()
        client.abort()
        waiting.join(10)
        assert errors == ["it closed the connection"]
        client.close()
