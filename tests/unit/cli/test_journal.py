"""What `eehal serve` sends to systemd's journal, to a socket that stands for that of journald."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.cli.run._journal import LONGEST, SystemdJournal, journal_of
from end_effector_hal.cli.run._voices import Changes, Words
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import NotReadyError
from end_effector_hal.vocabulary import Alarm
from tests.support.virtual_tool import VirtualTool


class Journald:
    """The other end, which reads only when it is asked to."""

    def __init__(self, path: Path) -> None:
        self.address = str(path)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(self.address)
        self._socket.setblocking(False)

    def read(self) -> list[dict[str, str]]:
        """All records that wait."""
        found = []
        while True:
            try:
                data = self._socket.recv(1 << 20)
            except BlockingIOError:
                return found
            record = {}
            while data:
                name, _, data = data.partition(b"\n")
                size = int.from_bytes(data[:8], "little")
                record[name.decode()] = data[8 : 8 + size].decode(errors="replace")
                assert data[8 + size : 9 + size] == b"\n"
                data = data[9 + size :]
            found.append(record)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def journald(tmp_path: Path) -> Iterator[Journald]:
    journald = Journald(tmp_path / "socket")
    yield journald
    journald.close()


def test_a_grip_that_times_out_is_found_by_its_fields(journald: Journald) -> None:
    description = load(profile_path())
    tool = VirtualTool(description, "never-confirms:top_vacuum")
    changes = Changes(description, Words(journal=SystemdJournal("my_tool", journald.address)))
    tool.run(1.0)
    tool.command("grip")
    tool.run(40.0)
    records = []
    for status in tool.statuses:
        changes.status(status)
        records += journald.read()
    assert {(each["SYSLOG_IDENTIFIER"], each["EEHAL_TOOL"]) for each in records} == {("eehal", "my_tool")}
    late = [each for each in records if each.get("EEHAL_EVENT") == "TimedOut"]
    assert [(each["EEHAL_ACTUATOR"], each["EEHAL_ATTEMPT"], each["PRIORITY"]) for each in late] == [
        ("top_vacuum", str(attempt), "4") for attempt in (1, 2, 3)
    ]
    assert late[1]["MESSAGE"] == "Top vacuum was not confirmed within 5 s: attempt 2 of 3."
    ended = next(each for each in records if each.get("EEHAL_CAUSE"))
    assert (ended["EEHAL_EVENT"], ended["EEHAL_CAUSE"], ended["EEHAL_STATE"]) == (
        "StateChanged",
        "TIMED_OUT",
        "GRIP_ERROR",
    )
    assert any(each.get("EEHAL_EVENT") == "ChangerChanged" for each in records)


def test_an_alarm_has_its_id_and_an_error_its_priority(journald: Journald) -> None:
    words = Words(journal=SystemdJournal("my_tool", journald.address))
    alarm = Alarm("grip.leak", "top_vacuum", {"rate": 1.0})
    words.alarm(0, alarm, over=False)
    words.alarm(0, alarm, over=True)
    words.error(NotReadyError("The tool is not ready.", todo="Look."))
    fields = ("EEHAL_EVENT", "EEHAL_ALARM", "EEHAL_ABOUT", "PRIORITY")
    assert [tuple(map(each.get, fields)) for each in journald.read()] == [
        ("AlarmBegan", "grip.leak", "top_vacuum", "4"),
        ("AlarmOver", "grip.leak", "top_vacuum", "6"),
        (None, None, None, "3"),
    ]


def test_a_text_of_others_makes_no_field_and_is_bounded(journald: Journald) -> None:
    journal = SystemdJournal("my_tool", journald.address)
    journal.send("a\nEEHAL_EVENT=TimedOut\n\udcff", {})
    journal.send("x" * 2 * LONGEST, {})
    first, second = journald.read()
    assert first["MESSAGE"] == "a\nEEHAL_EVENT=TimedOut\n?"
    assert "EEHAL_EVENT" not in first
    assert len(second["MESSAGE"]) == LONGEST


def test_a_journal_that_does_not_read_stops_nobody_and_the_lost_lines_are_counted(journald: Journald) -> None:
    journal = SystemdJournal("my_tool", journald.address)
    for number in range(5000):
        journal.send(str(number), {})
    kept = journald.read()
    assert 0 < len(kept) < 5000
    journal.send("later", {})
    counted, later = journald.read()
    assert counted["MESSAGE"].startswith(f"{5000 - len(kept)} lines were lost")
    assert (later["MESSAGE"], journald.read()) == ("later", [])


def test_a_journal_that_is_gone_stops_nobody(tmp_path: Path) -> None:
    journal = SystemdJournal("my_tool", str(tmp_path / "socket"))
    journal.send("lost", {})
    journald = Journald(tmp_path / "socket")
    journal.send("seen", {})
    assert [each["MESSAGE"] for each in journald.read()] == [
        "1 lines were lost: the journal did not accept them.",
        "seen",
    ]
    journald.close()


@pytest.mark.parametrize("connected", [True, False])
def test_only_a_stdout_that_is_the_journal_is_replaced(
    connected: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (tmp_path / "out").open("w") as out:
        found = os.fstat(out.fileno())
        monkeypatch.setattr("sys.stdout", out)
        monkeypatch.setenv("JOURNAL_STREAM", f"{found.st_dev}:{found.st_ino + (not connected)}")
        assert (journal_of("my_tool") is not None) is connected
