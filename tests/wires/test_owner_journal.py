"""The owner's memory: cut anywhere, it was true; what a new owner makes of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from zlib import crc32

import pytest
from keeping import BOTTOM, CYLINDER, GRIP, LINES, MS, OTHER, POLICY, SENSING, TOKEN, TOP, UNLOCK, Lines, S
from patience import PATIENCE_S

from end_effector_hal.errors import LineBusyError, LineRefusedError
from end_effector_hal.wires.owner import Keeper, WillStep
from end_effector_hal.wires.owner import _journal as module
from end_effector_hal.wires.owner._journal import Journal, read_journal
from end_effector_hal.wires.owner._memory import Bequest, Memory
from end_effector_hal.wires.owner._session import WillRunsError

UNWIND = (WillStep(TOP), WillStep(BOTTOM, after_us=2 * S))
GRIPPING = Bequest("grip", TOKEN, GRIP, UNWIND, ended=False, pid=7)
E_STOP = {"closed": "IL-13: the e-stop was opened."}
# one after the other, as an owner lives: faults come and go, wills change, it ends
LIFE = [
    Memory(clean=False),
    Memory({}, (GRIPPING,), clean=False),
    Memory({}, (replace_will := GRIPPING._replace(will=()),), clean=False),
    Memory(E_STOP, (replace_will,), clean=False),
    Memory(E_STOP, (GRIPPING._replace(ended=True),), clean=False),
    Memory({}, (), clean=False),
    Memory({"IL-03 unlock": "IL-03: unlock was active too long."}, (), clean=False),
]


def live(path: Path) -> None:
    journal = Journal(path)
    for memory in LIFE:
        journal.keep(memory)
    journal.close()


def test_what_is_kept_is_read(tmp_path: Path) -> None:
    for count in range(1, len(LIFE) + 1):
        journal = Journal(tmp_path / "journal")
        for memory in LIFE[:count]:
            journal.keep(memory)
        assert read_journal(tmp_path / "journal") == LIFE[count - 1]
        journal.close()
        assert read_journal(tmp_path / "journal") == replace(LIFE[count - 1], clean=True)
    assert read_journal(tmp_path / "none") == Memory()


def test_a_file_that_is_cut_at_any_byte_tells_what_was_true(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    live(path)
    whole, ends = path.read_bytes(), [*LIFE, replace(LIFE[-1], clean=True)]
    for size in range(len(whole) + 1):
        path.write_bytes(whole[:size])
        records = whole[:size].count(b"\n")
        assert read_journal(path) == (ends[records - 1] if records else Memory())


def test_a_byte_that_turned_over_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    live(path)
    whole, ends = path.read_bytes(), [Memory(), *LIFE, replace(LIFE[-1], clean=True)]
    for place in range(0, len(whole), 7):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        assert read_journal(path) in ends, place


def test_after_a_torn_record_the_file_begins_anew(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    live(path)
    path.write_bytes(path.read_bytes()[:-9])
    journal = Journal(path)
    assert journal.before == LIFE[-1]
    journal.keep(LIFE[1])
    journal.keep(LIFE[3])
    assert read_journal(path) == LIFE[3]


class Power:
    """Takes a picture of the folder around every call that touches the disk; a write also in its middle.

    ``safe`` is what is certainly on the disk: what was synced, under a name that was synced.
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder, self.pictures = folder, 0
        self.lasting: list[dict[str, str]] = []
        self.safe, self.synced = b"", dict[str, bytes]()
        for name in ("write", "fsync", "rename"):
            monkeypatch.setattr(module.os, name, self._around(name, getattr(os, name)))

    def _around(self, name, call):  # type: ignore[no-untyped-def]
        def done(*arguments):  # type: ignore[no-untyped-def]
            self.fail()
            if name == "write":
                fd, data = arguments
                for byte in data:
                    call(fd, bytes([byte]))
                    self.fail()
                return len(data)
            result = call(*arguments)
            self.fail()
            if name == "fsync":
                self._sync(Path(os.readlink(f"/proc/self/fd/{arguments[0]}")))
            return result

        return done

    def _sync(self, path: Path) -> None:
        if path.is_dir():
            inode = (path / "journal").stat().st_ino
            self.safe = self.synced.get(str(inode), b"")
            return
        self.synced[str(path.stat().st_ino)] = path.read_bytes()
        if path.name == "journal":
            self.safe = path.read_bytes()

    def surely(self) -> Memory:
        """What is found at least, whatever else was lost."""
        copy = self.folder / "copy"
        copy.write_bytes(self.safe)
        return read_journal(copy)

    def fail(self) -> None:
        """The power goes here: what was promised last must be there, or what is being promised."""
        self.pictures += 1
        found = read_journal(self.folder / "journal")
        assert found.faults in self.lasting[-2:], (found, self.lasting)


def test_the_power_may_go_at_any_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    power = Power(tmp_path, monkeypatch)
    power.lasting = [{}]
    monkeypatch.setattr(module, "LONGEST", 400)  # begun anew several times
    for _ in range(2):
        journal = Journal(tmp_path / "journal")
        for memory in [*LIFE, LIFE[3], LIFE[4]]:
            power.lasting.append(dict(memory.faults))
            journal.keep(memory)
            power.lasting = power.lasting[-1:]
            assert power.surely().faults == memory.faults
            assert read_journal(tmp_path / "journal") == memory
        journal.close()
    assert power.pictures > 2000


def test_only_what_matters_waits_for_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal, synced = Journal(tmp_path / "journal"), []
    journal.keep(LIFE[0])
    monkeypatch.setattr(module.os, "fsync", synced.append)
    journal.keep(LIFE[1])
    journal.keep(LIFE[2])
    journal.keep(LIFE[2])
    assert synced == []
    journal.keep(LIFE[3])
    assert len(synced) == 1
    journal.close()
    assert len(synced) == 2


def test_it_does_not_grow_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LONGEST", 2_000)
    journal = Journal(tmp_path / "journal")
    for _ in range(100):
        for memory in LIFE:
            journal.keep(memory)
    assert (tmp_path / "journal").stat().st_size < 2_500
    assert read_journal(tmp_path / "journal") == LIFE[-1]
    journal.close()
    assert [path.name for path in tmp_path.iterdir()] == ["journal"]


def test_a_disk_that_fails_ends_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    journal = Journal(folder / "journal")
    shutil.rmtree(folder)
    for memory in LIFE:
        journal.keep(memory)
    journal.close()
    assert caplog.text.count("cannot be written: No such file or directory") == 1
    (tmp_path / "folder").mkdir()
    assert Journal(tmp_path / "folder").before == Memory()


@pytest.mark.parametrize("text", ["", "\n", "hello\n", "00000000 {}\n", "\0" * 5000, "[" * 5000 + "\n"])
def test_what_is_no_journal_is_an_empty_memory(tmp_path: Path, text: str) -> None:
    (tmp_path / "journal").write_text(text)
    assert Journal(tmp_path / "journal").before == Memory()


# What a new owner makes of it


def keeper(*clients: Bequest, faults: dict[str, str] | None = None, **active: bool) -> tuple[Keeper, Lines]:
    lines = Lines(**active)
    return Keeper(lines, POLICY, 0, Memory(faults or {}, clients, clean=False)), lines


def test_a_client_that_comes_back_goes_on() -> None:
    new, lines = keeper(GRIPPING, bottom=True, top=True)
    session = new.hello("grip", TOKEN, GRIP, UNWIND, 500 * MS)
    new.expire(1 * S)
    assert new.sessions == [session]
    assert lines.written == []
    new.write(session, {CYLINDER: True}, None, 1 * S)


def test_a_client_that_does_not_come_back_is_dead_and_its_will_is_done() -> None:
    new, lines = keeper(GRIPPING, bottom=True, top=True)
    assert new.deadline == 1 * S
    assert new.expire(1 * S - 1) == []
    new.expire(1 * S)
    new.advance(1 * S)
    assert new.levels[BOTTOM]
    assert not new.levels[TOP]
    new.advance(3 * S)
    assert lines.written == [(0, TOP, False), (0, BOTTOM, False)]
    assert new.sessions == []


def test_a_client_that_was_started_again_meanwhile_finds_the_will_executed() -> None:
    new, _ = keeper(GRIPPING, bottom=True, top=True)
    with pytest.raises(WillRunsError, match="the will of grip is being executed"):
        new.hello("grip", OTHER, GRIP, (), 100 * MS)
    new.advance(2_100 * MS)
    assert not new.levels[BOTTOM]
    new.hello("grip", OTHER, GRIP, (), 2_100 * MS)


def test_a_pid_does_not_tell_who_comes_back() -> None:
    """In PID namespaces of their own, as in containers, all clients have pid 0."""
    new, _ = keeper(GRIPPING._replace(pid=0), bottom=True, top=True)
    with pytest.raises(WillRunsError, match="the will of grip is being executed"):
        new.hello("grip", OTHER, GRIP, (), 100 * MS, pid=0)
    new.advance(2_100 * MS)
    assert new.levels == dict.fromkeys(LINES, False)
    session = new.hello("grip", OTHER, GRIP, UNWIND, 2_100 * MS, pid=0)
    assert not session.overtaken
    with pytest.raises(LineBusyError, match=r"belongs to grip \(in another container\)"):
        new.hello("other", TOKEN, GRIP, (), 2_100 * MS, pid=0)


def test_what_an_older_owner_wrote_down_can_be_shown(tmp_path: Path) -> None:
    """It took texts that nobody can encode from anybody."""
    text = rb'{"faults":{"x\ud800":"IL-04:\nb\udfffits\u0000"},"clients":[["gr\ud800p",7,[],[],true]],"clean":false}'
    (tmp_path / "journal").write_bytes(b"%08x %s\n" % (crc32(text), text))
    memory = read_journal(tmp_path / "journal")
    assert memory.faults == {"x?": "IL-04: b?its?"}
    assert memory.clients[0].client == "gr?p"


def test_a_client_that_was_written_down_with_its_pid_alone_cannot_come_back(tmp_path: Path) -> None:
    """As the version before this one did."""
    text = b'{"faults":{},"clients":[["grip",7,["bottom"],[{"line":"bottom"}],false]],"clean":false}'
    (tmp_path / "journal").write_bytes(b"%08x %s\n" % (crc32(text), text))
    (old,) = read_journal(tmp_path / "journal").clients
    assert old == Bequest("grip", "", ("bottom",), (WillStep(BOTTOM),), ended=False)
    for token in (OTHER, "7"):
        new, _ = keeper(old, bottom=True)
        new.hello("changer", token, (UNLOCK,), (), 100 * MS)
        assert new.levels[BOTTOM]
        session = new.hello("grip", token, GRIP, (), 100 * MS)
        assert not new.levels[BOTTOM], (
            "its will was executed, as that of any program that another one follows"
        )
        assert not session.overtaken


def test_what_was_held_stays_held_through_the_death_of_both() -> None:
    new, lines = keeper(GRIPPING._replace(will=()), bottom=True, top=True)
    new.expire(10 * S)
    new.advance(10 * S)
    assert lines.written == []
    assert new.hello("grip", OTHER, GRIP, (), 10 * S)


def test_a_will_that_was_being_executed_is_executed_to_its_end() -> None:
    new, _ = keeper(GRIPPING._replace(ended=True), bottom=True)
    with pytest.raises(WillRunsError):
        new.hello("grip", TOKEN, GRIP, (), 0)
    new.advance(2 * S)
    assert new.levels == dict.fromkeys(LINES, False)


def test_lines_that_this_owner_has_not_are_forgotten() -> None:
    elsewhere = Bequest(
        "grip", TOKEN, ("elsewhere", TOP), (WillStep("elsewhere"), WillStep(TOP)), ended=False
    )
    new, lines = keeper(elsewhere, top=True)
    new.expire(1 * S)
    new.advance(1 * S)
    assert lines.written == [(0, TOP, False)]


def test_faults_stay_latched_through_a_restart() -> None:
    new = Keeper(Lines(), SENSING, 0, Memory(E_STOP))
    new.sensed.tell({"free": True, "locked": True, "closed": True}, 0, 0)
    session = new.hello("grip", TOKEN, GRIP, (), 0)
    with pytest.raises(LineRefusedError, match="the e-stop was opened; reset the faults first"):
        new.write(session, {BOTTOM: True}, None, 0)
    assert new.memory.faults == E_STOP
    new.reset(0)
    new.write(session, {BOTTOM: True}, None, 0)
    assert new.memory.faults == {}


def test_the_memory_is_what_the_next_one_needs() -> None:
    first = Keeper(Lines(), POLICY, 0)
    session = first.hello("grip", TOKEN, GRIP, (), 100 * MS)
    first.write(session, {BOTTOM: True}, UNWIND, 100 * MS)
    changer = first.hello("changer", OTHER, (UNLOCK,), (), 100 * MS)
    left = Bequest("grip", TOKEN, tuple(sorted(GRIP)), UNWIND, ended=False)
    assert first.memory == Memory(
        {}, (left, Bequest("changer", OTHER, (UNLOCK,), (), ended=False)), clean=False
    )
    first.bye(changer, (), 200 * MS)
    first.dead(session, "killed", 200 * MS)
    assert first.memory.clients == (left._replace(ended=True),)
    first.advance(9 * S)
    assert first.memory == Memory(clean=False)


def test_il_03_is_told_until_a_reset_also_after_a_restart() -> None:
    first = Keeper(Lines(), POLICY, 0)
    changer = first.hello("changer", OTHER, (UNLOCK,), (), 100 * MS)
    first.write(changer, {UNLOCK: True}, None, 100 * MS)
    first.advance(100 * MS + 3 * S)
    faults = first.memory.faults
    assert faults == {
        "IL-03 unlock": "IL-03: unlock (tool changer) was active for its longest time and was ended."
    }
    second = Keeper(Lines(), POLICY, 0, Memory(faults))
    assert second.memory.faults == faults
    changer = second.hello("changer", OTHER, (UNLOCK,), (), 100 * MS)
    second.write(changer, {UNLOCK: True}, None, 100 * MS)
    second.reset(200 * MS)
    assert second.memory.faults == {}


# Real processes

OWNER = """
import sys
from end_effector_hal.wires import Policy, VirtualLines, serve
chip, socket, journal, *lines = sys.argv[1:]
policy = Policy(lines, faults=["sensor_fault"])
serve(VirtualLines(chip), socket, policy, journal=journal, on_ready=lambda owner: print("ready", flush=True))
"""


@pytest.mark.wall
def test_when_both_are_killed_the_next_owner_does_what_the_client_has_left(tmp_path: Path) -> None:
    from end_effector_hal.wires import OwnerClient, VirtualChip, read_chip

    chip = VirtualChip.create(tmp_path / "chip", LINES).path
    command = [
        sys.executable,
        "-c",
        OWNER,
        *map(str, (chip, tmp_path / "sock", tmp_path / "journal")),
        *LINES,
    ]

    @contextmanager
    def owner() -> Iterator[subprocess.Popen[bytes]]:
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            try:
                assert process.stdout
                assert process.stdout.readline() == b"ready\n"
                yield process
                process.wait(PATIENCE_S)
            finally:
                process.kill()

    with owner() as first:
        client = OwnerClient(tmp_path / "sock", "grip", [BOTTOM, TOP])
        client.attend(alive=lambda: False)
        client.set({BOTTOM: True, TOP: True}, [WillStep(TOP), WillStep(BOTTOM, after_us=100_000)])
        while not client.levels()[BOTTOM]:  # IL-10 lets it wait after the start
            time.sleep(0.01)
        client.latch("sensor_fault", "IL-04: both bits are set.")
        first.kill()
    client.close()
    assert read_chip(chip).lines[BOTTOM].level
    with owner() as second, OwnerClient(tmp_path / "sock", "look") as look:
        status = look.status()
        assert (status["unclean"], status["faults"]) == (True, {"sensor_fault": "IL-04: both bits are set."})
        assert status["clients"][0]["absent"]
        while look.status()["clients"]:
            time.sleep(0.01)
        assert look.levels() == dict.fromkeys(LINES, False)
        second.terminate()
    with owner() as third, OwnerClient(tmp_path / "sock", "look") as look:
        assert not look.status()["unclean"]
        look.reset()
        third.kill()
    assert read_journal(tmp_path / "journal") == Memory(clean=False)
