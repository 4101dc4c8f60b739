"""A question to a program: whatever listens at its socket, there is an answer and no traceback."""

from __future__ import annotations

import socket
from contextlib import suppress
from pathlib import Path
from threading import Thread

import pytest

from end_effector_hal.runtime.stream import MOST_BYTES, ask_program


@pytest.mark.wall
@pytest.mark.parametrize(
    "said",
    [
        b"[]\n",
        b"7\n",
        b"{}\n",
        b"{broken\n",
        b"\xff\n",
        b'{"kind": "answer-to", "id": 1, "accepted": "yes"}\n',
        b"9" * (MOST_BYTES + 10) + b"\n",
        b"",
    ],
    ids=["list", "number", "empty", "broken", "no text", "half an answer", "endless", "nothing"],
)
def test_what_is_no_answer_is_a_sentence(tmp_path: Path, said: bytes) -> None:
    path = tmp_path / "tool.grip"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        listening.bind(str(path))
        listening.listen()

        def serve() -> None:
            sock, _ = listening.accept()
            with sock:
                sock.recv(1000)
                with suppress(OSError):  # nobody reads the rest
                    sock.sendall(said)

        served = Thread(target=serve)
        served.start()
        answer = ask_program(path, "grip", "reload")
        served.join()
    assert not answer.accepted
    assert not answer.decided
    assert answer.reason.startswith("The grip program ")


def test_nobody_listens(tmp_path: Path) -> None:
    answer = ask_program(tmp_path / "tool.grip", "grip", "reload")
    assert (answer.accepted, answer.decided) == (False, False)
    assert (
        answer.reason
        == f"The grip program of this tool does not run: nothing listens at {tmp_path / 'tool.grip'}."
    )
