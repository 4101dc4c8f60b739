"""The thread that gives the commands of ``eehal run``, and its prompt, where the system has no memory left."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from end_effector_hal.cli.run._session import CommandThread, Prompt
from end_effector_hal.errors import ReportedError


def test_a_step_that_fails_ends_itself_only() -> None:
    ended, worked = threading.Event(), threading.Event()

    def fails() -> Iterator[None]:
        yield
        raise MemoryError

    def works() -> Iterator[None]:
        while not ended.wait(0.0):
            yield
        worked.set()

    commands = CommandThread()
    for steps in (works(), fails(), fails()):
        commands.give(steps)
    ended.set()
    assert worked.wait(10.0)
    assert commands.alive()


def test_a_line_that_finds_no_memory_is_refused_and_the_next_one_is_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lines: list[str | type[Exception]] = [MemoryError, "grip", EOFError]

    def read(_: str) -> str:
        line = lines.pop(0)
        if isinstance(line, str):
            return line
        raise line

    monkeypatch.setattr("builtins.input", read)
    monkeypatch.setattr("time.sleep", lambda _: None)
    refused: list[ReportedError] = []
    assert len(list(Prompt(shown=False).commands(refused.append))) == 1
    assert ["not enough memory" in str(error) for error in refused] == [True]
