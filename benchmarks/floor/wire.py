"""Shared parts of the floor's programs: port, client of the arbiter, commands and notes of the parent."""

from __future__ import annotations

import json
import os
import random
import select
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from itertools import count

GO = b"!"
"""Prefix of a frame that is forwarded to the arbiter, like a confirming one; other frames end at the reader."""

LAST_US = 500_000
"""Time after the end of a block in which its last messages arrive."""


def now_us() -> int:
    return time.monotonic_ns() // 1000


def rest_until(at: int) -> None:
    time.sleep(max(0, at - now_us()) / 1e6)


def read_frames(path: str) -> Iterator[bytes]:
    """Yield the lines of a serial port, waiting in select as the product's reader does."""
    fd, rest = os.open(path, os.O_RDONLY | os.O_NOCTTY), b""
    while True:
        select.select([fd], [], [])
        *frames, rest = (rest + os.read(fd, 4096)).split(b"\n")
        yield from frames


def word_of(frame: bytes) -> bytes:
    """Return the word of a frame: the ping ``p12`` of ``!p12,…``."""
    return frame[1:].split(b",", 1)[0]


class Arbiter:
    """A client of the arbiter with one request at a time."""

    def __init__(self, path: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        while self._socket.connect_ex(path):
            time.sleep(0.05)
        self._lock = threading.Lock()

    def ask(self, word: bytes) -> None:
        with self._lock:
            self._socket.sendall(word + b"\n")
            self._socket.recv(4096)


def obey(run: Callable[[list[str]], None]) -> None:
    """Run each line of standard input; print ``ready`` first and ``done`` after each."""
    print("ready", flush=True)
    for line in sys.stdin:
        run(line.split())
        print("done", flush=True)


class Notes:
    """JSON lines for the parent, kept in memory until the end of a block."""

    def __init__(self, path: str) -> None:
        self._path, self._taken = path, list[dict[str, object]]()

    def add(self, **fields: object) -> None:
        self._taken.append(fields)

    def write(self) -> None:
        """Write the notes; called after the last message of a block."""
        taken, self._taken = self._taken, []
        with open(self._path, "a", encoding="utf-8") as file:
            file.writelines(json.dumps(note) + "\n" for note in taken)


def give_goals(notes: Notes, give: Callable[[int], None]) -> None:
    """Obey ``run SECONDS``: send and note five goals a second, at random phases."""
    numbers = count(1)

    def run(words: list[str]) -> None:
        end = now_us() + round(float(words[1]) * 1e6)
        while now_us() + 300_000 < end:
            time.sleep(random.uniform(0.1, 0.3))
            number, at = next(numbers), now_us()
            give(number)
            notes.add(goal=f"c{number}", at=at)
        rest_until(end + LAST_US)
        notes.write()

    obey(run)
