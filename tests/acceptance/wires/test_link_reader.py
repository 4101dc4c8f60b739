import os
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.errors import LinkBusyError, LinkError
from end_effector_hal.signals import Frame
from end_effector_hal.wires import now_us
from end_effector_hal.wires.link import LinkState, PtyPair, _reader, open_port
from end_effector_hal.wires.link._reader import LinkReader

pytestmark = pytest.mark.wall

CODEC = get_codec("ees1-ascii")


def line(seq):
    return CODEC.encode(Frame(0, seq, 20 * seq, {"bottom": seq}))


class Heard:
    """Collects what a reader reports; a test waits for a condition on it."""

    def __init__(self):
        self.frames, self.changes = [], []
        self._changed = threading.Condition()

    def frame(self, frame):
        with self._changed:
            self.frames.append(frame)
            self._changed.notify_all()

    def change(self, health):
        with self._changed:
            self.changes.append(health)
            self._changed.notify_all()

    def wait(self, condition):
        with self._changed:
            assert self._changed.wait_for(condition, 10), (self.frames, self.changes)

    def wait_state(self, state, count=1):
        self.wait(lambda: [change.state for change in self.changes].count(state) >= count)

    def wait_frames(self, count):
        self.wait(lambda: len(self.frames) >= count)

    @property
    def states(self):
        return [change.state for change in self.changes]


@pytest.fixture
def heard():
    return Heard()


@pytest.fixture
def port(tmp_path):
    return str(tmp_path / "uart")


def reader(port, heard):
    return LinkReader(port, "ees1-ascii", None, heard.frame, heard.change)


def test_frames_come_with_the_time_of_reading(port, heard):
    with PtyPair(port) as pty, reader(port, heard) as link:
        heard.wait_state(LinkState.SILENT)
        before = now_us()
        pty.write(b"noise" + line(1) + line(2)[:20])
        heard.wait_frames(1)
        pty.write(line(2)[20:])
        heard.wait_frames(2)
        assert [frame.values["bottom"] for frame in heard.frames] == [1, 2]
        assert before <= heard.frames[0].at <= heard.frames[1].at <= now_us()
        assert heard.states == [LinkState.SILENT, LinkState.UP]
        health = link.health
        assert (health.state, health.frames, health.errors, health.opened) == (
            LinkState.UP,
            2,
            {"noise": 5},
            1,
        )
        assert health.since <= heard.frames[0].at + 100_000


def test_every_byte_goes_through_unchanged(port, heard):
    with PtyPair(port) as pty, LinkReader(port, "legacy-nibble", None, heard.frame, heard.change) as link:
        heard.wait_state(LinkState.SILENT)
        pty.write(bytes(range(256)))
        heard.wait_frames(16)
        heard.wait(lambda: link.health.bytes == 256)


def test_what_was_sent_before_opening_is_not_delivered(port, heard):
    with PtyPair(port) as pty:
        while pty.write(line(1)):
            pass
        with reader(port, heard):
            heard.wait_state(LinkState.SILENT)
            pty.write(b"\r\n" + line(2))
            heard.wait_frames(1)
    assert heard.frames[0].seq == 2


class Stalled(Heard):
    """Stands still at the frame 1 until it is let go: meanwhile the kernel keeps what comes."""

    def __init__(self):
        super().__init__()
        self.go = threading.Event()

    def frame(self, frame):
        super().frame(frame)
        if frame.seq == 1:
            self.go.wait(10)


def test_what_waited_to_be_read_is_stamped_as_old_as_it_is(port):
    heard = Stalled()
    with PtyPair(port) as pty, reader(port, heard):
        heard.wait_state(LinkState.SILENT)
        pty.write(line(1))
        heard.wait_frames(1)
        pty.write(b"".join(line(2 + n) for n in range(40)))
        time.sleep(1)
        heard.go.set()
        heard.wait_frames(41)
    newest = heard.frames[-1].at
    assert [newest - frame.at for frame in heard.frames[1:]] == [20_000 * n for n in range(39, -1, -1)]


@pytest.mark.parametrize("frames", [1, 5])
def test_what_may_have_come_before_a_silence_is_as_old_as_it_can_be(port, frames):
    """The process stood still for a second: five frames came, and then, perhaps, the cable off."""
    heard = Stalled()
    with PtyPair(port) as pty, reader(port, heard):
        heard.wait_state(LinkState.SILENT)
        pty.write(line(1))
        heard.wait_frames(1)
        begun = now_us()
        pty.write(b"".join(line(2 + n) for n in range(frames)))
        time.sleep(1)
        heard.go.set()
        heard.wait_frames(1 + frames)
        time.sleep(0.2)
        pty.write(line(9))  # a link that is heard again after a silence is new
        heard.wait_frames(2 + frames)
    assert all(frame.at <= begun for frame in heard.frames[1:-1])
    assert now_us() - heard.frames[-1].at < 200_000


def test_when_the_buffer_of_the_kernel_was_full_all_of_it_is_thrown_away(port):
    heard = Stalled()
    with PtyPair(port) as pty, reader(port, heard) as link:
        heard.wait_state(LinkState.SILENT)
        pty.write(line(1))
        heard.wait_frames(1)
        while pty.write(line(2)):
            pass
        heard.go.set()
        while link.health.errors.get("late", 0) < 4_000:
            time.sleep(0.01)
        pty.write(b"\r\n" + line(3))
        heard.wait_frames(2)
    assert [frame.seq for frame in heard.frames] == [1, 3]


def test_it_comes_back_when_the_other_end_does(port, heard):
    with reader(port, heard) as link:
        heard.wait_state(LinkState.DOWN)
        assert "does not exist" in heard.changes[0].error
        for life in (1, 2):
            with PtyPair(port) as pty:
                heard.wait_state(LinkState.SILENT, life)
                pty.write(line(life))
                heard.wait_frames(life)
            heard.wait_state(LinkState.DOWN, life + 1)
        assert link.health.opened == 2
    assert "the port was lost" in next(c.error for c in heard.changes[1:] if c.state is LinkState.DOWN)
    life = [LinkState.SILENT, LinkState.UP, LinkState.DOWN]
    assert [state for state, _ in groupby(heard.states)] == [LinkState.DOWN, *life, *life]


HOLDER = """
import sys, time
from end_effector_hal.wires.link import open_port
port = open_port(sys.argv[1], 9600)
print("open", flush=True)
time.sleep(60)
"""


@contextmanager
def held(port):
    """Another process has the port open."""
    child = subprocess.Popen([sys.executable, "-c", HOLDER, port], stdout=subprocess.PIPE)
    try:
        assert child.stdout.readline() == b"open\n"
        yield child
    finally:
        child.kill()
        child.communicate()


def test_a_second_reader_is_told_who_reads(port, heard):
    with PtyPair(port), held(port) as child:
        link = reader(port, heard)
        with pytest.raises(LinkBusyError, match=rf"pid {child.pid} \(python -c"):
            link.start(patience_s=0.2)
        link.close()
        assert heard.changes == []
        # a predecessor that ends in time is no obstacle
        timer = threading.Timer(0.2, child.kill)
        timer.start()
        link.start(patience_s=10)
        heard.wait_state(LinkState.SILENT)
        link.close()
        timer.join()


def test_a_port_that_was_lost_to_somebody_else_names_the_pid(port, heard):
    with reader(port, heard):
        heard.wait_state(LinkState.DOWN)
        with PtyPair(f"{port}.there") as pty, held(f"{port}.there") as child:
            os.symlink(os.path.realpath(f"{port}.there"), port)
            heard.wait(lambda: f"pid {child.pid} (" in heard.changes[-1].error)
            child.kill()
            heard.wait_state(LinkState.SILENT)
            assert pty


def test_errors_are_sentences(tmp_path, monkeypatch):
    with pytest.raises(LinkError, match="does not exist") as caught:
        open_port(str(tmp_path / "none"), 9600)
    assert "Ports here:" in str(caught.value)
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path, "/dev/null"):
        with pytest.raises(LinkError, match="not a serial port"):
            open_port(str(path), 9600)

    def deny(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("serial.Serial", deny)
    with pytest.raises(LinkError, match="group dialout"):
        open_port("/dev/ttyS0", 9600)


def test_back_off_doubles_up_to_five_seconds(monkeypatch):
    link = LinkReader("/no/port", "ees1-ascii")
    waits = []
    link._wake_read = 0
    monkeypatch.setattr(_reader.select, "select", lambda r, w, x, wait: waits.append(wait))
    for _ in range(8):
        link._sleep()
    assert waits == [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 5.0, 5.0]


def test_a_failing_listener_stops_nothing(port, caplog):
    heard = Heard()

    def fail(frame):
        heard.frame(frame)
        raise ZeroDivisionError

    with PtyPair(port) as pty, LinkReader(port, CODEC, None, fail, heard.change):
        heard.wait_state(LinkState.SILENT)
        pty.write(line(1))
        pty.write(line(2))
        heard.wait_frames(2)
    assert "ZeroDivisionError" in caplog.text


def test_close_in_every_state(port, heard):
    reader(port, heard).close()
    link = reader(port, heard)
    link.start()
    heard.wait_state(LinkState.DOWN)
    link.close()
    link.close()
    with PtyPair(port) as pty:
        inside = LinkReader(
            port, CODEC, None, lambda frame: (inside.close(), heard.frame(frame)), heard.change
        )
        inside.start()
        heard.wait_state(LinkState.SILENT)
        pty.write(line(1))
        heard.wait_frames(1)
    assert not [
        thread
        for thread in threading.enumerate()
        if thread.name == f"link {port}" and thread.is_alive() and not thread.join(5) and thread.is_alive()
    ]


def test_waiting_costs_nothing(port, heard):
    with PtyPair(port), reader(port, heard):
        heard.wait_state(LinkState.SILENT)
        before = time.process_time()
        threading.Event().wait(0.5)
        assert time.process_time() - before < 0.05


def test_pty_replaces_a_dead_link_and_no_file(tmp_path):
    link = tmp_path / "uart"
    link.symlink_to("/dev/pts/no-such")
    with PtyPair(link) as pty:
        assert os.readlink(link) == pty.slave_name
    assert not link.is_symlink()
    link.write_text("mine")
    with pytest.raises(LinkError, match="cannot be linked"):
        PtyPair(link)
    assert link.read_text() == "mine"


def test_pty_leaves_the_link_of_a_successor(tmp_path):
    first = PtyPair(tmp_path / "uart")
    first.close()
    second = PtyPair(tmp_path / "uart")
    first.close()
    assert os.readlink(tmp_path / "uart") == second.slave_name
    with open_port(str(tmp_path / "uart"), 115_200) as port:
        port.write(b"hello\r\n\x00\x11")
        assert second.read() == b"hello\r\n\x00\x11"
        assert second.read() == b""
    second.close()


def test_a_second_pair_at_the_same_place_says_who_has_it(tmp_path: Path) -> None:
    place = tmp_path / "uart"
    with PtyPair(place) as first:
        with pytest.raises(LinkBusyError, match=rf"the port is held by pid {os.getpid()} "):
            PtyPair(place)
        assert os.readlink(place) == first.slave_name
    with PtyPair(place):
        assert place.is_symlink()
