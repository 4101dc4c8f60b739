"""Somebody else than who runs the tests: a process that loads what it needs as root and then is nobody.

It needs no interpreter, no environment and no checkout that others may read: after it has become nobody it imports
nothing any more. Only root can become somebody else.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from typing import IO

NOBODY = 65_534
_BECOME = """
def become_nobody(groups):
    import os, sys
    os.setgroups(groups), os.setgid({nobody}), os.setuid({nobody})
    sys.path.clear(), sys.path_importer_cache.clear()
"""


def as_nobody(
    program: str, *arguments: str, groups: Sequence[int] = (), stdin: IO[str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a program in Python; it calls ``become_nobody(groups)`` once everything is imported."""
    assert os.geteuid() == 0
    return subprocess.run(
        [sys.executable, "-c", _BECOME.format(nobody=NOBODY) + f"groups = {list(groups)}\n" + program, *arguments],
        stdin=stdin, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
