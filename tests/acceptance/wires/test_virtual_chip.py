import json
import os
import subprocess
import sys
import threading

import pytest

from end_effector_hal.errors import LineBusyError, LineNotFoundError, WireError
from end_effector_hal.wires.lines import ChipWatcher, Edge, VirtualChip, VirtualLines, read_chip
from end_effector_hal.wires.lines._chip_log import ChipState, LineState

pytestmark = pytest.mark.wall

NAMES = ("SODIMM_206", "SODIMM_208", "SODIMM_210")


@pytest.fixture
def path(tmp_path):
    return VirtualChip.create(tmp_path / "chip", NAMES, {"SODIMM_208": "up"}, label="verdin").path


class Edges(list):
    """Collects edges, and lets a test wait for the n-th."""

    def __init__(self):
        self._changed = threading.Condition()

    def __call__(self, edge):
        with self._changed:
            self.append(edge)
            self._changed.notify_all()

    def wait(self, count):
        with self._changed:
            assert self._changed.wait_for(lambda: len(self) >= count, 10), list(self)
        return list(self)


def test_a_fresh_chip_has_inputs_at_their_pulls(path):
    low, high = LineState("in", False), LineState("in", True)
    assert read_chip(path) == ChipState("verdin", {"SODIMM_206": low, "SODIMM_208": high, "SODIMM_210": low})


def test_an_input_at_its_pull_up_is_no_command():
    assert not Edge(0, "a", "in", True, 1).active
    assert Edge(0, "a", "out", True, 1).active


def test_records_are_json_lines_in_one_write(path):
    lines = VirtualLines(path, clock=iter((100, 200)).__next__)
    lines.request(NAMES[:2])
    lines.set({"SODIMM_208": True, "SODIMM_206": False})
    entries = [json.loads(text) for text in path.read_text().splitlines()[1:] if text]
    assert entries == [
        {"t": 100, "line": "SODIMM_206", "direction": "out", "level": 0, "pid": os.getpid()},
        {"t": 100, "line": "SODIMM_208", "direction": "out", "level": 0, "pid": os.getpid()},
        {"t": 200, "line": "SODIMM_208", "direction": "out", "level": 1, "pid": os.getpid()},
    ]
    lines.close()


def test_a_torn_record_counts_for_nothing(path):
    with path.open("ab") as file:
        file.write(b'{"t": 1, "line": "SODIMM_206", "direction": "out", "lev')
    lines = VirtualLines(path)
    assert lines.request(["SODIMM_210"]) == {"SODIMM_210": False}
    assert read_chip(path).lines["SODIMM_210"] == LineState("out", False)
    assert read_chip(path).lines["SODIMM_206"] == LineState("in", False)
    lines.close()


@pytest.mark.parametrize("text", [b"", b"[]\n", b'{"chip": 1}\n', b"\xff\n", b'{"t": 1}\n', b"3\n"])
def test_another_file_is_refused(tmp_path, text):
    (tmp_path / "x").write_bytes(text)
    with pytest.raises(WireError, match="not that of a virtual chip"):
        read_chip(tmp_path / "x")


def test_a_missing_chip(tmp_path):
    with pytest.raises(WireError, match="no virtual chip"):
        VirtualLines(tmp_path / "none").request(["a"])
    with pytest.raises(WireError, match="cannot be claimed"):
        VirtualChip.create(tmp_path / "no" / "chip", ["a"])


def test_create_is_refused_while_the_lines_are_held(path):
    lines = VirtualLines(path)
    lines.request(NAMES)
    with pytest.raises(LineBusyError, match=rf"pid {os.getpid()} \("):
        VirtualChip.create(path, NAMES)
    assert VirtualChip.create(path, ["x"], exist_ok=True).read().label == "verdin"
    lines.close()
    VirtualChip.create(path, ["x"])
    assert list(read_chip(path).lines) == ["x"]


def test_levels_outlive_a_killed_process(path):
    program = (
        "import sys, time; from end_effector_hal.wires.lines import VirtualLines\n"
        "lines = VirtualLines(sys.argv[1]); lines.request(['SODIMM_206', 'SODIMM_208'])\n"
        "lines.set({'SODIMM_208': True}); print('ready', flush=True); time.sleep(60)"
    )
    child = subprocess.Popen([sys.executable, "-c", program, str(path)], stdout=subprocess.PIPE)
    try:
        assert child.stdout.readline() == b"ready\n"
        with pytest.raises(LineBusyError, match=f"pid {child.pid} "):
            VirtualLines(path).request(NAMES)
    finally:
        child.kill()
        child.communicate()
    before = path.read_bytes()
    lines = VirtualLines(path)
    assert lines.request(NAMES[:2]) == {"SODIMM_206": False, "SODIMM_208": True}
    assert path.read_bytes() == before
    lines.close()


def test_watcher_sees_every_record_in_order(path):
    edges = Edges()
    lines = VirtualLines(path, clock=iter(range(100, 1000)).__next__)
    lines.request(["SODIMM_206"])
    with ChipWatcher(path, edges):
        for i in range(200):
            lines.set({"SODIMM_206": i % 2 == 0})
        seen = edges.wait(200)
    assert [(edge.at, edge.level) for edge in seen] == [(101 + i, i % 2 == 0) for i in range(200)]
    lines.close()


def test_watcher_starts_where_the_chip_stands(path):
    lines, edges = VirtualLines(path, clock=lambda: 7), Edges()
    lines.request(NAMES)
    watcher = ChipWatcher(path, edges)
    assert watcher.start() == read_chip(path)
    lines.set({"SODIMM_208": True})
    assert edges.wait(1) == [Edge(7, "SODIMM_208", "out", True, os.getpid())]
    assert watcher.state == read_chip(path)
    watcher.close()
    watcher.close()
    lines.close()


def test_watcher_sees_a_power_up(path):
    lines, edges = VirtualLines(path), Edges()
    lines.request(NAMES)
    lines.set({"SODIMM_206": True})
    lines.close()
    with ChipWatcher(path, edges) as watcher:
        VirtualChip.create(path, NAMES, {"SODIMM_208": "up"})
        after = edges.wait(3)
        assert {edge.line: (edge.direction, edge.level) for edge in after} == dict(read_chip(path).lines)
        lines.request(["SODIMM_206"])
        assert edges.wait(4)[3].direction == "out"
        assert watcher.state == read_chip(path)
    lines.close()


def test_watcher_waits_for_a_file_that_comes_later(tmp_path):
    edges = Edges()
    with ChipWatcher(tmp_path / "chip", edges) as watcher:
        assert watcher.state == ChipState()
        VirtualChip.create(tmp_path / "chip", ["a"], {"a": "up"})
        (edge,) = edges.wait(1)
        assert edge[1:4] == ("a", "in", True)


def test_watcher_outlives_a_failing_callback(path, caplog):
    edges = Edges()

    def fail_once(edge):
        edges(edge)
        if len(edges) == 1:
            raise ZeroDivisionError

    lines = VirtualLines(path)
    with ChipWatcher(path, fail_once):
        lines.request(["SODIMM_206"])
        lines.set({"SODIMM_206": True})
        edges.wait(2)
    assert "ZeroDivisionError" in caplog.text
    lines.close()


def test_watcher_closes_from_its_own_thread(path):
    edges, lines = Edges(), VirtualLines(path)
    watcher = ChipWatcher(path, lambda edge: (watcher.close(), edges(edge)))
    watcher.start()
    lines.request(["SODIMM_206"])
    edges.wait(1)
    lines.close()


def test_watcher_needs_the_directory(tmp_path):
    with pytest.raises(WireError, match="cannot be watched"):
        ChipWatcher(tmp_path / "no" / "chip", print).start()


def test_unknown_line(path):
    with pytest.raises(LineNotFoundError, match=r"SODIMM_211 \(did you mean SODIMM_210\?\), x\."):
        VirtualLines(path).request(["SODIMM_211", "x"])
    lines = VirtualLines(path)
    lines.request(NAMES)
    lines.close()
