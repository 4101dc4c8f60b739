"""One subject of the verification, with the answers given within its time."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from end_effector_hal.errors import ReportedError

BENCHMARKS = Path(__file__).parents[1]


@dataclass(frozen=True)
class Answer:
    """The answer to one query. ``states``: stored symbolic states; ``seconds``: processor time."""

    query: str
    sentence: str
    holds: bool
    states: int
    seconds: float
    wall_s: float


@dataclass(frozen=True)
class Subject:
    """The queries to one network, answered in a separate process.

    Attributes:
        load_s: time for reading the file and building the network.
        finished: whether every query was answered in time.
        loaded_kib, peak_kib: largest memory of the process, before the first query and in all.
    """

    name: str
    size: int
    load_s: float
    answers: tuple[Answer, ...]
    finished: bool
    loaded_kib: int
    peak_kib: int

    @property
    def bytes_per_state(self) -> float:
        """Memory of the search, without the loaded network, per stored state of the largest query."""
        most = max((answer.states for answer in self.answers), default=0)
        return (self.peak_kib - self.loaded_kib) * 1024 / most if most else 0.0

    @property
    def seconds(self) -> float:
        """Seconds of all answers."""
        return sum(answer.seconds for answer in self.answers)

    @property
    def states(self) -> int:
        """States of all answers."""
        return sum(answer.states for answer in self.answers)

    def as_json(self) -> dict[str, Any]:
        """Return the JSON for the results file."""
        found = vars(self) | {"answers": [vars(answer) for answer in self.answers]}
        return found | {"bytes_per_state": self.bytes_per_state}


def check(name: str, size: int, longest_s: float) -> Subject:
    """Check a subject of `_worker` in a separate process; raises ReportedError if that fails."""
    command = [sys.executable, "-m", "verification._worker", name, str(size)]
    try:
        done = subprocess.run(command, cwd=BENCHMARKS, capture_output=True, timeout=longest_s)
        finished, text = done.returncode == 0, done.stdout
        if not finished:
            raise ReportedError(f"{name} {size} failed:\n{done.stderr.decode()[-2000:]}")
    except subprocess.TimeoutExpired as stopped:
        finished, text = False, stopped.stdout or b""
    notes = [json.loads(line) for line in text.decode().split("\n")[:-1]]
    peaks_kib = [note.pop("peak_kib") for note in notes] or [0]
    load_s = notes[0]["load_s"] if notes else longest_s
    answers = tuple(Answer(**note) for note in notes[1:])
    return Subject(name, size, load_s, answers, finished, peaks_kib[0], max(peaks_kib))
