"""What the doctor says of the sensor link."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from end_effector_hal.cli.doctor import _link
from end_effector_hal.wires.link import PtyPair
from tests.unit.cli.doctor.parts import Machine, Sender, frame


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
@pytest.mark.wall
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
            f"{machine.port} exists and is free; not listened to",
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
