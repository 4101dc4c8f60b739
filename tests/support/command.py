"""``eehal`` with its exit code checked, in a process of its own or in this one."""

from __future__ import annotations

import subprocess

from click.testing import CliRunner

from end_effector_hal.cli._main import eehal as group
from end_effector_lab.processes import EEHAL


def eehal(*words: object, expected: int = 0) -> str:
    """Return the output of a command, which runs in a process."""
    done = subprocess.run([*EEHAL, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == expected, f"{words}: {done.stdout}{done.stderr}"
    return done.stdout


def eehal_here(*words: object) -> str:
    """Return the output of a command that starts no process and ends by itself; a process would start for a second."""
    done = CliRunner().invoke(group, [*map(str, words)], catch_exceptions=False)
    assert done.exit_code == 0, f"{words}: {done.output}"
    return done.stdout
