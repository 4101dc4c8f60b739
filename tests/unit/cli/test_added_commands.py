"""What another distribution adds to ``eehal`` is distrusted: one that is broken is one sentence and hides no other."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

LAMP = Path(__file__).parents[1] / "timed_automata" / "models" / "lamp.xml"
POINTS = """\
[end_effector_hal.commands]
absent = nowhere:command
wrong = json:dumps
good = added_command:command
[end_effector_hal.figures]
absent = nowhere:figures
"""
COMMAND = """\
import click
@click.command(short_help="says hello")
def command():
    click.echo("hello")
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    metadata = tmp_path / "added-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: added\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text(POINTS)
    (tmp_path / "added_command.py").write_text(COMMAND)
    return tmp_path


def eehal(site: Path, *arguments: str) -> tuple[int, str, str]:
    program = [sys.executable, "-c", "from end_effector_hal.cli import main; main()", *arguments]
    env = {**os.environ, "PYTHONPATH": str(site)}
    done = subprocess.run(program, env=env, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def test_the_help_names_all_and_says_which_cannot_be_loaded(site: Path) -> None:
    code, out, err = eehal(site, "--help")
    assert (code, err) == (0, "")
    found = (
        line.split(maxsplit=1)
        for line in out.partition("Added by other distributions:")[2].splitlines()
        if line.split()[1:]
    )
    lines = dict(found)
    assert lines["good"] == "says hello"
    assert lines["absent"].startswith("(the command absent cannot be loaded")
    assert lines["wrong"].startswith("(the command wrong: the entry point must name a click.Command")


def test_one_that_works_runs(site: Path) -> None:
    assert eehal(site, "good") == (0, "hello\n", "")


@pytest.mark.parametrize(
    ("name", "why"), [("absent", "No module named 'nowhere'"), ("wrong", "must name a click.Command")]
)
def test_one_that_is_broken_is_refused_in_a_sentence(site: Path, name: str, why: str) -> None:
    code, _, err = eehal(site, name)
    assert code == 2
    assert why in err
    assert "Traceback" not in err


@pytest.mark.thinned
def test_broken_figures_of_another_hide_not_ours(site: Path, tmp_path: Path) -> None:
    code, _, err = eehal(site, "model", "show", "--model", str(LAMP), "-o", str(tmp_path / "drawings"))
    assert (code, err) == (0, "")
