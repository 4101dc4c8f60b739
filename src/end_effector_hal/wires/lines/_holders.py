"""Who may hold a line: the kernel tells a name that the holder chose, /proc tells which processes hold any."""

from __future__ import annotations

import glob
import os

from end_effector_hal.wires._claim import program_name

# how the kernel calls the descriptor of a request
_REQUEST = "anon_inode:gpio-line"


def stop_holders(proc: str = "/proc") -> str:
    """What to do about a busy line; names each process that holds lines, as far as this user may see."""
    pids = set()
    for link in glob.iglob(f"{proc}/[0-9]*/fd/*"):
        try:
            if os.readlink(link).startswith(_REQUEST):
                pids.add(int(link.split("/")[-3]))
        except OSError:
            continue
    found = [f"pid {pid} ({program_name(pid)})" for pid in sorted(pids)]
    if not found:
        return "Stop the program that holds it."
    return f"Stop the program that holds it; {' and '.join(found)} {'hold' if len(found) > 1 else 'holds'} lines."
