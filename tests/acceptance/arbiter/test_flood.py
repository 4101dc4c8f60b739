"""Real processes that flood the arbiter's socket, beside one that writes lines."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient, ArbiterServer, Policy
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from tests.support.keeping import BOTTOM, LINES, TOP

pytestmark = [pytest.mark.wall, pytest.mark.alone]
FLOOD = """
import json, socket, sys, threading
def connected():
    sock = socket.socket(socket.AF_UNIX)
    sock.settimeout(0.1)
    try:
        sock.connect(sys.argv[1])
    except OSError:
        pass
    return sock
socks, number, ended = [connected() for _ in range(64)], 0, threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
print("floods", flush=True)
while not ended.is_set():
    for index in range(64):
        number += 1
        names = {f"{number} {each}": True for each in range(32)}
        tell = json.dumps({"op": "tell", "predicates": names, "at_us": 1}).encode() + b"\\n"
        try:
            socks[index].send(b'{"op": "status"}\\n' * 500 + tell + b"9" * 3000 + b"\\n")
            socks[index].recv(1 << 20)
        except OSError:
            socks[index].close()
            socks[index] = connected()
"""


def test_who_writes_lines_is_served_in_a_flood(tmp_path: Path) -> None:
    chip, path = VirtualChip.create(tmp_path / "chip", LINES).path, tmp_path / "sock"
    with ArbiterServer(VirtualLines(chip), path, Policy(LINES, min_switch_us=0)) as arbiter:
        serving = threading.Thread(target=arbiter.run)
        serving.start()
        command = [sys.executable, "-c", FLOOD, str(path)]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as flood:
            try:
                assert flood.stdout is not None
                assert flood.stdout.readline() == b"floods\n"
                client = ArbiterClient(path, "grip", [BOTTOM, TOP], timeout_s=30.0)
                for number in range(100):
                    assert client.set({BOTTOM: number % 2 == 0}).delay_us == 0
                with ArbiterClient(path, "changer", ["unlock"], timeout_s=30.0) as late:
                    assert late.levels()["unlock"] is False
                (grip,) = client.status()["clients"]
                assert (grip["client"], grip["ended"]) == ("grip", False)
                assert not client.declared_dead()
                client.close()
            finally:
                flood.kill()
                arbiter.stop()
                serving.join()
