"""One subject of the verification: what was answered within its time."""

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
    """Of one query. ``states``: symbolic states that were stored; ``seconds``: of the processor."""

    query: str
    sentence: str
    holds: bool
    states: int
    seconds: float
    wall_s: float


@dataclass(frozen=True)
class Subject:
    """``load_s``: reading the file and putting it together; ``finished``: every query was answered in time."""

    name: str
    size: int
    load_s: float
    answers: tuple[Answer, ...]
    finished: bool
    peak_kib: int

    @property
    def seconds(self) -> float:
        """Of all answers."""
        return sum(answer.seconds for answer in self.answers)

    @property
    def states(self) -> int:
        """Of all answers."""
        return sum(answer.states for answer in self.answers)

    def as_json(self) -> dict[str, Any]:
        """For the file."""
        return vars(self) | {"answers": [vars(answer) for answer in self.answers]}


def check(name: str, size: int, longest_s: float) -> Subject:
    """Check a subject of `_worker` in a process of its own; raises ReportedError when that fails."""
    command = [sys.executable, "-m", "verification._worker", name, str(size)]
    try:
        done = subprocess.run(command, cwd=BENCHMARKS, capture_output=True, timeout=longest_s)
        finished, text = done.returncode == 0, done.stdout
        if not finished:
            raise ReportedError(f"{name} {size} failed:\n{done.stderr.decode()[-2000:]}")
    except subprocess.TimeoutExpired as stopped:
        finished, text = False, stopped.stdout or b""
    notes = [json.loads(line) for line in text.decode().split("\n")[:-1]]
    peak_kib = max((note.pop("peak_kib") for note in notes), default=0)
    load_s = notes[0]["load_s"] if notes else longest_s
    return Subject(name, size, load_s, tuple(Answer(**note) for note in notes[1:]), finished, peak_kib)
