"""A virtual chip, a line arbiter on a real socket, and a client without manners."""

import json
import socket
import threading
from contextlib import contextmanager

from end_effector_hal.arbiter import ArbiterClient, ArbiterServer, Policy
from end_effector_hal.wires.lines import VirtualChip, VirtualLines, read_chip

UNLOCK, BOTTOM, TOP = LINES = ("SODIMM_206", "SODIMM_208", "SODIMM_212")
TOKEN = "a" * 32
POLICY = Policy(LINES, [(UNLOCK, BOTTOM), (UNLOCK, TOP)], {UNLOCK: 300_000}, min_switch_us=0)


class Bench:
    """A chip, the path of a socket, and arbiters on them."""

    def __init__(self, folder):
        self.chip = VirtualChip.create(folder / "chip", LINES, {BOTTOM: "up"}).path
        self.socket = folder / "run" / "arbiter.sock"

    @contextmanager
    def arbiter(self, policy=POLICY):
        with ArbiterServer(VirtualLines(self.chip), self.socket, policy) as arbiter:
            thread = threading.Thread(target=arbiter.run)
            thread.start()
            try:
                yield arbiter
            finally:
                arbiter.stop()
                thread.join()

    def client(self, name="grip", lines=(BOTTOM, TOP), **more):
        return ArbiterClient(self.socket, name, lines, **{"patience_s": 0.0} | more)

    def levels(self):
        return [read_chip(self.chip).lines[line].level for line in LINES]


class Raw:
    """A client without manners."""

    def __init__(self, bench):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(10)
        self.socket.connect(str(bench.socket))
        self.file = self.socket.makefile("rb")

    def say(self, text):
        self.socket.sendall(text if isinstance(text, bytes) else json.dumps(text).encode() + b"\n")

    def ask(self, text):
        self.say(text)
        return json.loads(self.file.readline())

    def close(self):
        self.file.close()
        self.socket.close()
