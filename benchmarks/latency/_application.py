"""Shared parts of the applications: they execute lines of their standard input, and note what they received.

``cycles N``: N times grip and drop, each after a random rest. ``lose N``: the same, with a wait until the held part is
lost. ``grip`` and ``drop`` do one. A failure is reported, and the part is dropped.
"""

from __future__ import annotations

import json
import random
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us

LOST_S = 10.0


class Application:
    """One application.

    Args:
        notes: a file; after each executed line it receives a JSON line for each goal and each state.
    """

    def __init__(self, notes: str) -> None:
        self._notes, self._taken = Path(notes), list[dict[str, object]]()
        self._lost = threading.Event()

    def state(self, received: int, at: int, ee: int, outputs: Sequence[bool]) -> None:
        """Note a state of ``at`` that was received; µs."""
        self._taken.append({"received": received, "at": at, "ee": ee, "outputs": list(outputs)})
        if ee == EndEffectorState.GRIP_ERROR:
            self._lost.set()

    def obey(self, command: Callable[[str], str]) -> None:
        """Execute the lines of standard input; print ``ready``, and ``done`` after each line.

        Args:
            command: does ``grip`` or ``drop``, given by name, and returns why it failed; "": it succeeded.
        """
        print("ready", flush=True)
        for line in sys.stdin:
            word, *rest = line.split()
            for name in self._names(word, *map(int, rest)):
                self._give(name, command)
            time.sleep(0.2)
            taken, self._taken = self._taken, []
            with self._notes.open("a", encoding="utf-8") as file:
                file.writelines(json.dumps(note) + "\n" for note in taken)
            print("done", flush=True)

    def _names(self, word: str, count: int = 1) -> Iterator[str]:
        if word in ("grip", "drop"):
            yield word
            return
        for _ in range(count):
            self._lost.clear()
            yield "grip"
            if word == "lose" and not self._lost.wait(LOST_S):
                print("failed: nothing was lost.", flush=True)
            yield "drop"

    def _give(self, name: str, command: Callable[[str], str]) -> None:
        time.sleep(random.uniform(0.05, 0.1))  # at any phase of the frames
        self._taken.append({"goal": name, "at": now_us()})
        if why := command(name):
            print(f"failed: {name}{why}", flush=True)
            time.sleep(1.0)
            command("drop")
