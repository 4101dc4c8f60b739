"""`eehal` in a process of its own in which some modules cannot be imported."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

_PROGRAM = """
import sys

BLOCKED = {blocked}

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in BLOCKED:
            raise ModuleNotFoundError(f"{{name}} is blocked", name=name)

for name in BLOCKED:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Blocked())
from end_effector_hal.cli import main
main()
"""


def eehal_without(
    blocked: Sequence[str], *words: object, cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end; an import of a blocked module raises ModuleNotFoundError."""
    program = [sys.executable, "-c", _PROGRAM.format(blocked=tuple(blocked)), *map(str, words)]
    return subprocess.run(program, capture_output=True, text=True, check=False, cwd=cwd)
