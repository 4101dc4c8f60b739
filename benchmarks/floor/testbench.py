"""The floor's testbench: it writes frames into a pty and watches a file.

``run SECONDS PHASE_US``: 50 frames a second at this phase; each tenth is a ping. It notes pings and edges.
"""

from __future__ import annotations

import os
import sys
import threading
import tty
from itertools import count
from pathlib import Path

from inotify_simple import INotify, flags
from wire import GO, LAST_US, Notes, now_us, obey, rest_until

PERIOD_US, PING_EACH = 20_000, 10
FILLING = b"," + b"0" * 60  # a frame is about as long as one of the product


class Lines(threading.Thread):
    """Detects each line that is appended to a file."""

    def __init__(self, path: Path, notes: Notes) -> None:
        super().__init__(daemon=True)
        path.touch()
        self._notes = notes
        self._fd = os.open(path, os.O_RDONLY)
        self._inotify = INotify()
        self._inotify.add_watch(path, flags.MODIFY)

    def run(self) -> None:
        while True:
            self._inotify.read()
            data = os.read(self._fd, 1 << 16)
            seen = now_us()
            for line in data.splitlines():
                word, at = line.split()
                self._notes.add(edge=word.decode(), at=int(at), seen=seen)


def main(link: str, lines: str, path: str) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    os.symlink(os.ttyname(slave), link)
    notes, numbers = Notes(path), count(1)
    Lines(Path(lines), notes).start()

    def run(words: list[str]) -> None:
        due = (now_us() // PERIOD_US + 1) * PERIOD_US + int(words[2])
        end = due + round(float(words[1]) * 1e6)
        while due < end:
            rest_until(due)
            number = next(numbers)
            ping = number % PING_EACH == 0
            frame = (GO if ping else b"$") + b"p%d" % number + FILLING + b"\n"
            at = now_us()
            os.write(master, frame)
            if ping:
                notes.add(ping=f"p{number}", at=at)
            due += PERIOD_US
        rest_until(end + LAST_US)
        notes.write()

    obey(run)


if __name__ == "__main__":
    main(*sys.argv[1:])
