"""Who goes first on a busy machine.

Programs with deadlines of milliseconds cannot wait for their time slice behind a load: where it is allowed (root) they
have real-time priority. Else they take their chance. Nor can they wait for a disk: their files are in memory.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from functools import cache

MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else tempfile.gettempdir()
GUEST, WIRES = 1, 2
"""The testbench goes before the guest: it is the world, which waits for nobody."""


def before_others(priority: int) -> list[str]:
    """What to put before a command; nothing where that is not allowed."""
    return ["chrt", "--rr", str(priority)] if _allowed() else []


@cache
def _allowed() -> bool:
    try:
        return subprocess.run(["chrt", "--rr", "1", "true"], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False
