"""The line arbiter as a process, on a disk that is full, read-only, hangs or comes back: what is held stays held."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.runtime import latch_stop
from end_effector_hal.vocabulary import LastWillStep
from end_effector_hal.wires.lines import VirtualChip, read_chip
from tests.support.keeping import BOTTOM, LINES, TOP
from tests.support.nightly import first_of
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.proving import proving

pytestmark = [
    pytest.mark.wall,
    pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a disk"),
]
ARBITER = """
import sys
from end_effector_hal.arbiter import ArbiterServer, Policy
from end_effector_hal.arbiter.rules._policy import Need
from end_effector_hal.wires.lines import VirtualLines
from tests.support.nightly import first_of
chip, socket, journal, *lines = sys.argv[1:]
closed = Need("closed", "IL-13", "the e-stop is closed", "the e-stop is open", latched="the e-stop was opened")
policy = Policy(lines, needs={line: (closed,) for line in lines}, faults={"sensor_fault": "changer"})
with ArbiterServer(VirtualLines(chip), socket, policy, journal) as arbiter:
    arbiter.serve(lambda _: print("ready", flush=True))
"""
UNWIND = [LastWillStep(TOP), LastWillStep(BOTTOM, after_us=100_000)]


class Disk:
    """A file system of its own in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.image = folder, folder.with_name("image")

    def fill(self) -> None:
        with (self.folder / "filler").open("wb", buffering=0) as filler:
            for size in (1 << 16, 1 << 9, 1):
                try:
                    while True:
                        filler.write(b"x" * size)
                except OSError:
                    pass

    def free(self) -> None:
        (self.folder / "filler").unlink()

    def fail(self) -> None:
        """The kernel meets an error and mounts it read-only, whoever writes."""
        device = Path(_output("findmnt", "-n", "-o", "SOURCE", self.folder)).name
        Path(f"/sys/fs/ext4/{device}/trigger_fs_error").write_text("played by a test")

    def repair(self) -> None:
        """As a person does."""
        subprocess.run(["umount", "-l", self.folder], check=True)
        subprocess.run(["e2fsck", "-fy", self.image], check=False, stdout=subprocess.DEVNULL)
        subprocess.run(["mount", "-o", "loop", self.image, self.folder], check=True)

    @contextmanager
    def hanging(self) -> Iterator[None]:
        """Whoever writes waits."""
        subprocess.run(["fsfreeze", "-f", self.folder], check=True)
        try:
            yield
        finally:
            subprocess.run(["fsfreeze", "-u", self.folder], check=True)


def _output(*words: object) -> str:
    return subprocess.run(
        [str(word) for word in words], check=True, stdout=subprocess.PIPE, text=True
    ).stdout.strip()


@pytest.fixture
def memory_disk(tmp_path: Path) -> Iterator[Disk]:
    folder = tmp_path / "disk"
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m,mode=700", "none", folder], check=True)
    yield Disk(folder)
    subprocess.run(["umount", "-l", folder], check=True)


@pytest.fixture
def block_disk(tmp_path: Path) -> Iterator[Disk]:
    disk = Disk(tmp_path / "disk")
    folder, image = disk.folder, disk.image
    folder.mkdir()
    with image.open("wb") as file:
        file.truncate(8 << 20)
    subprocess.run(["mkfs.ext4", "-q", "-F", "-O", "^has_journal", image], check=True)
    subprocess.run(["mount", "-o", "loop,errors=remount-ro", image, folder], check=True)
    yield disk
    subprocess.run(["umount", "-l", folder], check=True)


class Bench:
    """A virtual chip, an arbiter that is started again, and programs."""

    def __init__(self, folder: Path, run: Path, journal: Path) -> None:
        self.chip = VirtualChip.create(folder / "chip", LINES).path
        self.socket, self.journal = run / "sock", journal / "journal"

    @contextmanager
    def arbiter(self) -> Iterator[subprocess.Popen[bytes]]:
        words = [sys.executable, "-c", ARBITER, self.chip, self.socket, self.journal, *LINES]
        with subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE) as process:
            try:
                assert process.stdout
                assert process.stdout.readline() == b"ready\n"
                yield process
            finally:
                process.kill()
                process.wait(PATIENCE_S)

    def program(self) -> ArbiterClient:
        return ArbiterClient(self.socket, "grip", [BOTTOM, TOP])

    def look(self) -> ArbiterClient:
        return ArbiterClient(self.socket, "look")

    def faults(self) -> dict[str, str]:
        with self.look() as look:
            return dict(look.status()["faults"])

    def active(self) -> set[str]:
        return {name for name, line in read_chip(self.chip).lines.items() if line.level}

    def grip(self, program: ArbiterClient) -> None:
        """GRIPPING: both lines are active, the will unwinds."""
        with proving(self.socket, closed=True):
            wait_until("the sensors are heard in time", lambda: _is_written(program))
        wait_until("both lines", lambda: self.active() == {BOTTOM, TOP})


def change_much(program: ArbiterClient) -> None:
    """More than fits into what is left of a page of the disk; the last will unwinds."""
    for after_us in range(100, -1, -1):
        program.set({}, [LastWillStep(TOP, after_us=after_us), UNWIND[1]])


def hold_through_a_kill(bench: Bench, disk: Disk, hurt: str) -> None:
    """GRIPPING while the disk is hurt; a program in good order follows, grips and holds; the arbiter is killed."""
    with bench.arbiter() as first:
        program = bench.program()
        if hurt == "full":
            disk.fill()
        else:
            disk.fail()
        bench.grip(program)
        change_much(program)
        program.latch("sensor_fault", "IL-04: both bits are set.")
        wait_until("it is said", lambda: hurt == "full" or "journal" in bench.faults())
        if hurt == "full":
            disk.free()
        else:
            disk.repair()
        program.close(UNWIND)
        wait_until("unwound", lambda: not bench.active())
        follower = bench.program()
        bench.grip(follower)
        follower.set({}, [])  # GRIPPED
        follower.attend(alive=lambda: False)
        first.kill()
        first.wait(PATIENCE_S)
    with bench.arbiter():
        wait_until("the follower is dead", lambda: not _clients(bench))
        assert bench.active() == {BOTTOM, TOP}
        assert "sensor_fault" in bench.faults()
    follower.close()


def _clients(bench: Bench) -> list[dict[str, object]]:
    with bench.look() as look:
        return [client for client in look.status()["clients"] if client["client"] == "grip"]


@pytest.mark.parametrize("run_too", first_of([True, False], thinned=0))
def test_a_disk_that_was_full_for_a_while_drops_nothing(
    tmp_path: Path, memory_disk: Disk, *, run_too: bool
) -> None:
    run = memory_disk.folder if run_too else tmp_path
    hold_through_a_kill(Bench(tmp_path, run, memory_disk.folder), memory_disk, "full")


def test_a_disk_that_was_read_only_for_a_while_drops_nothing(tmp_path: Path, block_disk: Disk) -> None:
    hold_through_a_kill(Bench(tmp_path, tmp_path, block_disk.folder), block_disk, "read-only")


@pytest.mark.parametrize("run_too", first_of([True, False]))
def test_an_arbiter_that_starts_on_a_full_disk_says_so_and_holds(
    tmp_path: Path, memory_disk: Disk, *, run_too: bool
) -> None:
    bench = Bench(tmp_path, memory_disk.folder if run_too else tmp_path, memory_disk.folder)
    (memory_disk.folder / "sock.lock").touch()
    memory_disk.fill()
    with bench.arbiter() as first:
        program = bench.program()
        wait_until("it is said", lambda: "journal" in bench.faults())
        assert ("session record" in bench.faults()) == run_too
        bench.grip(program)
        program.attend(alive=lambda: False)
        first.kill()
        first.wait(PATIENCE_S)
    program.close()
    with bench.arbiter() as second:
        if run_too:  # nobody knows what the program has left
            assert bench.active() == {BOTTOM, TOP}
            assert "last wills" in bench.faults()
        else:
            wait_until("unwound", lambda: not bench.active())
        memory_disk.free()
        with bench.look() as look:
            wait_until("the disk is there again", lambda: _is_reset(look))
        second.terminate()
        second.wait(PATIENCE_S)


def _is_written(program: ArbiterClient) -> bool:
    try:
        program.set({BOTTOM: True, TOP: True}, UNWIND)
    except LineRefusedError:  # this machine was busy elsewhere: what was proven is too old
        return False
    return True


def _is_reset(look: ArbiterClient) -> bool:
    try:
        look.reset()
    except LineRefusedError:
        return False
    return look.status()["faults"] == {}


def test_the_latch_of_an_e_stop_survives_a_full_disk_and_a_kill(tmp_path: Path, memory_disk: Disk) -> None:
    bench = Bench(tmp_path, tmp_path, memory_disk.folder)
    with bench.arbiter() as first:
        memory_disk.fill()
        with bench.look() as look, bench.program() as program:
            change_much(program)
            with proving(bench.socket, closed=False):
                assert "closed" in look.status()["faults"]
        with proving(bench.socket, closed=True):
            assert "closed" in bench.faults()
        memory_disk.free()
        first.kill()
        first.wait(PATIENCE_S)
    with bench.arbiter():
        program = bench.program()
        with (
            proving(bench.socket, closed=True),
            pytest.raises(OSError, match="the e-stop was opened; reset the faults first"),
        ):
            program.set({BOTTOM: True}, [])
        program.close()


@pytest.mark.parametrize("full_at_the_start", [False, True])
def test_a_stop_survives_a_disk_that_fills_and_a_kill_or_says_that_it_may_not(
    tmp_path: Path, memory_disk: Disk, *, full_at_the_start: bool
) -> None:
    bench = Bench(tmp_path, memory_disk.folder, memory_disk.folder)
    (memory_disk.folder / "sock.lock").touch()
    if full_at_the_start:
        memory_disk.fill()
    with bench.arbiter() as first:
        with bench.look() as look:
            if not full_at_the_start:
                latch_stop(look)  # its journal is there by then
                look.reset()
                memory_disk.fill()
            said = latch_stop(look)
        assert ("It may be lost when the line arbiter ends" in said) == full_at_the_start
        first.kill()
        first.wait(PATIENCE_S)
    with bench.arbiter(), bench.program() as program:
        assert full_at_the_start or "stop" in bench.faults()
        if not full_at_the_start:
            with proving(bench.socket, closed=True), pytest.raises(OSError, match="IL-13"):
                program.set({BOTTOM: True}, [])


def test_a_disk_that_hangs_is_waited_for_by_nobody(tmp_path: Path, block_disk: Disk) -> None:
    """Leases, last wills and faults go on; it is an alarm, and over when the disk answers."""
    bench = Bench(tmp_path, tmp_path, block_disk.folder)
    with bench.arbiter():
        program = bench.program()
        bench.grip(program)
        with block_disk.hanging():
            program.latch("sensor_fault", "IL-04: both bits are set.")
            wait_until("it is said", lambda: "the disk does not answer" in bench.faults().get("journal", ""))
            program.attend(alive=lambda: False)
            wait_until("the last will", lambda: not bench.active())
        with bench.look() as look:
            wait_until("the disk is there again", lambda: _is_reset(look))
        program.close()


def test_when_both_are_killed_the_next_arbiter_does_what_the_client_has_left(tmp_path: Path) -> None:
    bench = Bench(tmp_path, tmp_path, tmp_path)
    with bench.arbiter() as first:
        program = bench.program()
        program.attend(alive=lambda: False)
        bench.grip(program)
        program.latch("sensor_fault", "IL-04: both bits are set.")
        first.kill()
        first.wait(PATIENCE_S)
    program.close()
    assert bench.active() == {BOTTOM, TOP}
    with bench.arbiter() as second, bench.look() as look:
        status = look.status()
        assert (status["unclean"], status["faults"]) == (True, {"sensor_fault": "IL-04: both bits are set."})
        assert status["clients"][0]["absent"]
        wait_until("the last will", lambda: not look.status()["clients"])
        assert bench.active() == set()
        look.reset()
        second.terminate()
        second.wait(PATIENCE_S)
    with bench.arbiter(), bench.look() as look:
        assert not look.status()["unclean"]
        assert look.status()["faults"] == {}


@pytest.mark.parametrize(
    "hurt", first_of(["the end is cut", "an older copy", "the end is empty", "the start is empty"], 1, 1)
)
def test_a_record_of_the_sessions_that_was_hurt_drops_nothing(tmp_path: Path, hurt: str) -> None:
    bench = Bench(tmp_path, tmp_path, tmp_path)
    record = tmp_path / "sock.sessions"
    with bench.arbiter() as first:
        program = bench.program()
        program.attend(alive=lambda: False)
        bench.grip(program)
        older = record.read_bytes()
        program.set({}, [])  # GRIPPED
        first.kill()
        first.wait(PATIENCE_S)
    program.close()
    whole = record.read_bytes()
    half = len(whole) // 2
    record.write_bytes(
        {
            "the end is cut": whole[:half],
            "the end is empty": whole[:half] + bytes(half),
            "the start is empty": bytes(half) + whole[half:],
            "an older copy": older,
        }[hurt]
    )
    with bench.arbiter():
        wait_until("the program is dead", lambda: not _clients(bench))
        assert bench.active() == {BOTTOM, TOP}
        assert "last wills" in bench.faults()
