"""The line arbiter and its clients as processes that are killed, stopped and ended."""

import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import pytest

from end_effector_hal.arbiter import ArbiterServer
from end_effector_hal.errors import (
    ArbiterError,
    LineBusyError,
)
from end_effector_hal.vocabulary import LastWillStep
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import ChipWatcher, VirtualLines
from tests.acceptance.arbiter.bench import BOTTOM, LINES, POLICY, TOP, UNLOCK
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = pytest.mark.wall


ARBITER = """
import sys
from end_effector_hal.arbiter import ArbiterServer, Policy
from end_effector_hal.wires.lines import VirtualLines
chip, socket, *lines = sys.argv[1:]
with ArbiterServer(VirtualLines(chip), socket, Policy(lines)) as arbiter:
    arbiter.serve(lambda _: print("ready", flush=True))
print("end", flush=True)
"""
CLIENT = """
import sys, time
from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.vocabulary import LastWillStep
socket, *lines = sys.argv[1:]
client = ArbiterClient(socket, "grip", lines)
will = [LastWillStep(line, False, i * 300_000) for i, line in enumerate(lines[::-1])]
client.set(dict.fromkeys(lines, True), will)
print("ready", flush=True)
time.sleep(60)
"""


@contextmanager
def process(program, *arguments):
    command = [sys.executable, "-c", program, *map(str, arguments)]
    child = subprocess.Popen(command, stdout=subprocess.PIPE)
    try:
        assert child.stdout.readline() == b"ready\n"
        yield child
    finally:
        child.kill()
        child.communicate()


def test_a_killed_arbiter_leaves_the_lines_and_the_next_adopts_them(bench):
    with process(ARBITER, bench.chip, bench.socket, *LINES) as first:
        with bench.client() as grip:
            with pytest.raises(LineBusyError, match=f"pid {first.pid} "):
                ArbiterServer(VirtualLines(bench.chip), bench.socket, POLICY)
            grip.set({BOTTOM: True}, [])
            wait_until("it", lambda: bench.levels()[1])
            first.kill()
            first.wait()
            with pytest.raises(ArbiterError):
                grip.levels()
        assert bench.socket.exists()
    records = bench.chip.read_bytes()
    with process(ARBITER, bench.chip, bench.socket, *LINES), bench.client() as grip:
        assert grip.levels() == {UNLOCK: False, BOTTOM: True, TOP: False}
        assert bench.chip.read_bytes() == records


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_an_arbiter_that_is_asked_to_end_leaves_the_lines_as_they_are(bench, number):
    with process(ARBITER, bench.chip, bench.socket, *LINES) as arbiter:
        grip = bench.client()
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
        wait_until("it", lambda: bench.levels()[1])
        arbiter.send_signal(number)
        assert arbiter.stdout.read() == b"end\n"
        assert arbiter.wait(PATIENCE_S) == 0
    assert bench.levels() == [False, True, False]
    assert not bench.socket.exists()
    grip.close()


def test_the_will_of_a_killed_client_is_executed_in_order_and_in_time(bench):
    edges = []
    with (
        process(ARBITER, bench.chip, bench.socket, *LINES),
        process(CLIENT, bench.socket, BOTTOM, TOP) as client,
    ):
        wait_until("it", lambda: bench.levels() == [False, True, True])
        with ChipWatcher(bench.chip, edges.append):
            killed = now_us()
            client.kill()
            client.wait()
            grip = bench.client()
            # The will ran to its end before the next client was let in.
            assert grip.levels() == dict.fromkeys(LINES, False)
            wait_until("it", lambda: len(edges) == 2)
            grip.close()
    assert [(edge.line, edge.level) for edge in edges] == [(TOP, False), (BOTTOM, False)]
    assert killed <= edges[0].at < killed + 3_000_000
    assert killed + 300_000 <= edges[1].at < killed + 3_000_000


def test_an_arbiter_that_ends_with_its_clients_still_executes_their_wills(bench):
    # as roslaunch does it at Ctrl-C: everybody is told to end, the arbiter first
    with (
        process(ARBITER, bench.chip, bench.socket, *LINES) as arbiter,
        process(CLIENT, bench.socket, BOTTOM, TOP) as client,
    ):
        wait_until("it", lambda: bench.levels() == [False, True, True])
        arbiter.send_signal(signal.SIGINT)
        time.sleep(0.2)
        client.kill()
        assert arbiter.wait(PATIENCE_S) == 0
    assert bench.levels() == [False, False, False]


def test_a_second_signal_ends_an_arbiter_at_once(bench):
    with (
        process(ARBITER, bench.chip, bench.socket, *LINES) as arbiter,
        process(CLIENT, bench.socket, BOTTOM, TOP),
    ):
        wait_until("it", lambda: bench.levels() == [False, True, True])
        arbiter.send_signal(signal.SIGINT)
        time.sleep(0.4)
        arbiter.send_signal(signal.SIGINT)
        assert arbiter.wait(PATIENCE_S) == 0
    assert bench.levels() == [False, True, True]


def test_a_stopped_client_is_dead_after_its_lease(bench):
    with bench.arbiter(), process(CLIENT, bench.socket, BOTTOM) as client:
        wait_until("it", lambda: bench.levels()[1])
        client.send_signal(signal.SIGSTOP)
        before = time.monotonic()
        wait_until("it", lambda: not bench.levels()[1])
        assert 0.7 < time.monotonic() - before < 5


def test_an_arbiter_that_was_stopped_kills_nobody(bench):
    with process(ARBITER, bench.chip, bench.socket, *LINES) as arbiter, bench.client(timeout_s=10) as grip:
        grip.set({BOTTOM: True}, [LastWillStep(BOTTOM)])
        arbiter.send_signal(signal.SIGSTOP)
        threading.Event().wait(1.5)
        arbiter.send_signal(signal.SIGCONT)
        assert grip.levels()[BOTTOM]
        threading.Event().wait(0.3)
        assert grip.levels()[BOTTOM]
