"""A person waits for the start of every command: what only another command needs is not loaded."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = {"lark", "matplotlib", "numpy", "pydantic", "rich", "ruamel.yaml"}
OURS = {"end_effector_hal.description", "end_effector_hal.runtime", "end_effector_lab.figures"}
CODE = """\
import sys
from end_effector_hal.cli import main
try: main()
except SystemExit as end: code = end.code
print(f"\\n{code}", *sys.modules)
"""


def loaded(*arguments: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", CODE, *arguments], capture_output=True, text=True, check=True
    )
    code, *modules = done.stdout.splitlines()[-1].split()
    assert code == "0", done.stderr
    return set(modules)


@pytest.mark.parametrize("arguments", [("--help",), ("--version",), ("verify", "--help"), ("plot", "--help")])
def test_help_reads_no_description(arguments: tuple[str, ...]) -> None:
    assert not loaded(*arguments) & (HEAVY | OURS)


def test_a_check_loads_nothing_that_draws() -> None:
    assert not loaded("check") & {"matplotlib", "numpy", "end_effector_lab.figures"}


def test_the_styles_are_those_of_the_figures() -> None:
    from end_effector_lab import figures
    from end_effector_lab.commands import _plot

    assert _plot.STYLES == figures.STYLES
