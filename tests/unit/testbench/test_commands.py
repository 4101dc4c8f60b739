from __future__ import annotations

import os

import pytest

from end_effector_hal.errors import UsageError
from end_effector_lab.testbench._program import Commands, Voice, lines_of


class Told:
    def __init__(self, *, as_json: bool = False) -> None:
        self.scenarios: list[str] = []
        self.ended = False
        self.commands = Commands(Voice(as_json=as_json), self.choose, self.end)

    def choose(self, text: str) -> None:
        if text == "wrong":
            raise UsageError("no fault is named 'wrong'.")
        self.scenarios.append(text)

    def end(self) -> None:
        self.ended = True


def test_scenario_and_quit(capsys: pytest.CaptureFixture[str]) -> None:
    told = Told()
    for line in ("scenario  fails-once:cylinder", "", "scenario wrong", "scenario", "stop"):
        told.commands.obey(line)
    assert told.scenarios == ["fails-once:cylinder"]
    assert not told.ended
    out, err = capsys.readouterr()
    assert out == "scenario: fails-once:cylinder\n"
    assert err.splitlines() == [
        "refused: no fault is named 'wrong'.",
        "refused: there is no command 'scenario'. There are: scenario TEXT, quit.",
        "refused: there is no command 'stop'. There are: scenario TEXT, quit.",
    ]
    told.commands.obey("quit")
    assert told.ended


def test_lines_come_in_pieces_and_the_last_may_lack_its_end() -> None:
    read, write = os.pipe()
    lines = lines_of(read)
    for piece in (b"scenario nom", b"inal\nscenario noise:0.1\nqu"):
        os.write(write, piece)
    assert [next(lines), next(lines)] == ["scenario nominal", "scenario noise:0.1"]
    os.write(write, b"it")
    os.close(write)
    assert list(lines) == ["quit"]
    os.close(read)


def test_a_terminal_that_another_program_has_ends_the_commands() -> None:
    assert list(lines_of(-1)) == []


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    told = Told(as_json=True)
    told.commands.obey("scenario nominal")
    told.commands.obey("scenario wrong")
    assert capsys.readouterr().out.splitlines() == [
        '{"schema_version": 1, "scenario": "nominal"}',
        """{"schema_version": 1, "refused": "no fault is named 'wrong'."}""",
    ]
