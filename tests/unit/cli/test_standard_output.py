"""Standard output that is full, or whose reader has gone: a sentence, and the exit code that a script relies on."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from rich.table import Table

from end_effector_hal.cli._output import print_table
from tests.support.refuted import REFUTED

EEHAL = "import sys; from end_effector_hal.cli import main; main()"
FULL = "The output cannot be written: No space left on device.\n"


def run(*arguments: str, stdout: int) -> tuple[int, str]:
    # without a buffer nothing is left that would fail again at the end of the interpreter
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    ended = subprocess.run(
        [sys.executable, "-c", EEHAL, *arguments],
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
            [sys.executable, "-c", "from end_effector_hal.cli import main; main()", *arguments],
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
