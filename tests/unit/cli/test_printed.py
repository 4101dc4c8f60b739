"""What a command prints: errors as sentences, progress on stderr, and what becomes of a full or closed output."""

from __future__ import annotations

import errno
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from rich.table import Table

from end_effector_hal.cli._output import print_table
from end_effector_hal.description import examine_text, profile_path
from end_effector_hal.errors import DescriptionError, UsageError
from tests.support.places import DOCS
from tests.support.refuted import REFUTED
from tests.support.terminal import on_a_terminal
from tests.unit.conftest import Whole

sys.path.insert(0, str(DOCS))
from _site._errors import raised

MAIN = "from end_effector_hal.cli import main; main()"
FULL = "The output cannot be written: No space left on device.\n"


def run(*arguments: str, stdout: int) -> tuple[int, str]:
    # without a buffer nothing is left that would fail again at the end of the interpreter
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    ended = subprocess.run(
        [sys.executable, "-c", MAIN, *arguments],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
        env=environment,
    )
    return ended.returncode, ended.stderr


@pytest.mark.parametrize(
    "arguments",
    [("check",), ("check", "--json"), ("check", "--json", "/nowhere.yaml"), ("export", "urdf"), ("--help",)],
    ids=" ".join,
)
def test_a_full_disk_is_one_sentence(arguments: tuple[str, ...]) -> None:
    full = os.open("/dev/full", os.O_WRONLY)
    try:
        assert run(*arguments, stdout=full) == (2, FULL)
    finally:
        os.close(full)


@pytest.mark.parametrize("arguments", [("check", "/nowhere.yaml"), ("replay", "/nowhere"), ("nonsense",)])
def test_an_error_that_nobody_can_read_keeps_its_exit_code(arguments: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [sys.executable, "-c", MAIN, *arguments],
            stdout=subprocess.PIPE,
            stderr=full,
            timeout=60,
        )
    assert (ended.returncode, ended.stdout) == (2, b"")


@pytest.mark.parametrize(("model", "code"), [(REFUTED, 4), ("<nta/>", 2)])
def test_the_verdict_does_not_depend_on_who_reads_it(tmp_path: Path, model: str, code: int) -> None:
    (tmp_path / "model.xml").write_text(model)
    reader, writer = os.pipe()
    os.close(reader)
    try:
        found, told = run("verify", "--model", str(tmp_path / "model.xml"), stdout=writer)
    finally:
        os.close(writer)
    assert found == code
    assert "Traceback" not in told
    assert os.strerror(errno.EPIPE) not in told


def test_a_long_row_stays_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("run", "replay", box=None, pad_edge=False)
    name = "a" * 150 + "[b]"
    table.add_row(name, "the same as recorded")
    print_table(table)
    head, row = capsys.readouterr().out.splitlines()
    assert head.split() == ["run", "replay"]
    assert row.split(maxsplit=1) == [name, "the same as recorded"]


# What a command prints of an error is a sentence: it begins upper case, unless a place or a name begins it.


def test_every_text_that_is_listed_begins_upper_case() -> None:
    listed = sorted({text for said in raised().values() for text, _ in said})
    assert len(listed) > 200
    lower = [text for text in listed if re.match(r"[a-z]+\s", UsageError(text).sentence)]
    assert lower == []


def test_a_place_begins_as_it_is_written() -> None:
    assert UsageError("it cannot be written.", where="out.csv").sentence == "out.csv: it cannot be written."
    faulty = DescriptionError(examine_text("name: 1\n", "my tool.yaml").diagnostics)
    assert faulty.sentence.startswith("my tool.yaml:1:")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "--simulate", "--scenario", "leek", str(profile_path())), "No fault is named 'leek'."),
        (("testbench", "--lines", "nowhere"), "Lines cannot be read from 'nowhere'."),
        (("demo", "--only", "nominall", "--no-ros"), "There is no scenario"),
        (("arbiter", "--profile", "nobody"), "No profile is named 'nobody'."),
    ],
)
def test_what_a_command_refuses(words: tuple[str, ...], said: str, whole: Whole) -> None:
    code, _, error = whole(*words)
    assert code == 2
    assert error.startswith(said), error


# What takes long says so: on stderr, never with JSON.


SLOW = """\
import sys, time
from end_effector_hal.cli import Progress
with Progress("Working", shown=sys.argv[1] == "words") as progress:
    time.sleep(1.3)
    progress("Still working")
    time.sleep(0.5)
    progress.clear()
    print("found")
"""


@pytest.mark.wall
def test_a_line_appears_after_a_second_says_what_is_done_and_goes() -> None:
    code, text = on_a_terminal([sys.executable, "-c", SLOW, "words"])
    assert code == 0
    assert "Working, 1 s" in text
    assert "Still working, 1 s" in text
    assert text.endswith("found\n")


@pytest.mark.wall
def test_with_json_there_is_none() -> None:
    assert on_a_terminal([sys.executable, "-c", SLOW, "json"]) == (0, "found\n")


def piped(program: str) -> tuple[str, str]:
    done = subprocess.run(
        [sys.executable, "-c", program, "words"], capture_output=True, text=True, check=True
    )
    return done.stdout, done.stderr


@pytest.mark.wall
def test_in_a_log_there_is_none_of_what_is_done_within_half_a_minute() -> None:
    assert piped(SLOW) == ("found\n", "")


@pytest.mark.wall
def test_in_a_log_what_takes_longer_is_a_line_now_and_then() -> None:
    short = "from end_effector_hal.cli import _output\n_output.LINE_S = 0.6\n"
    found, said = piped(short + SLOW)
    assert found == "found\n"
    assert said.splitlines()[0] == "Working, 1 s"
    assert "\x1b" not in said
    assert "\r" not in said
