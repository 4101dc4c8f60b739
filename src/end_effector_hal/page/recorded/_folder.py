"""The recordings of a folder, newest first, each described in one line without reading its traces."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

from end_effector_hal.errors import ReportedError
from end_effector_hal.recording import RunFile, RunInfo, read_run, read_states, read_story
from end_effector_hal.vocabulary import printable

MOST_LISTED = 200
MOST_SCANNED = 20_000
"""Largest number of the folder's entries that are inspected."""
MOST_TABLE_BYTES, MOST_INFO_BYTES = 2_000_000, 1_000_000
BUDGET_S = 4.0
"""Processor time for reading tables, seconds; after it, older recordings are listed without their story."""
MOST_S = 40.0
"""The same limit in elapsed time, seconds, for a slow disk."""
PROGRESS = "progress "
"""Prefix of a line on stderr with the share read, from the process that reads a recording for the page."""
_LONGEST = 160
BROKEN = (ReportedError, OSError, ValueError, ArithmeticError, LookupError, TypeError, RecursionError)
_TRACE = ".mcap"


def recording_folders(folder: Path) -> dict[str, Path]:
    """Return the recordings in a folder, or the folder itself, by id, newest first; links are not followed."""
    found: list[tuple[float, Path]] = []
    for path in (folder, *_inside(folder)):
        changed = changed_at(path)
        if changed is not None:
            found.append((changed, path))
    found.sort(key=lambda each: (-each[0], each[1].name))
    return {_id_of(path): path for _, path in found[:MOST_LISTED]}


def list_recordings(folder: Path, budget_s: float = BUDGET_S) -> dict[str, Any]:
    """Return the list as JSON, ``{folder, recordings}``; no content of a recording makes this fail.

    A recording has ``id``, by which a page requests it, ``name`` and ``changed`` (last write, s since 1970) of its
    folder, ``tool`` of its ``run.json``, ``story``: a sentence about the result of the run, or the reason why it is
    unknown, and ``length_s`` of its table of states (None: unknown).
    """
    spent, until = time.process_time() + budget_s, time.monotonic() + MOST_S
    rows = []
    for id_, path in recording_folders(folder).items():
        if time.process_time() < spent and time.monotonic() < until:
            found = _read(path)
        else:
            found = {"tool": "", "story": "not read: there are too many", "length_s": None}
        name, changed = printable(path.resolve().name), changed_at(path) or 0.0
        rows.append({"id": id_, "name": name, "changed": changed, **found})
    return {"folder": printable(str(folder)), "recordings": rows}


def has_links(path: Path) -> bool:
    """Return whether a recording contains symbolic links, which are not followed."""
    with os.scandir(path) as entries:
        return any(entry.is_symlink() for entry in entries)


def _inside(folder: Path) -> Iterator[Path]:
    try:
        with os.scandir(folder) as entries:
            for number, entry in enumerate(entries):
                if number >= MOST_SCANNED:
                    return
                if entry.is_dir(follow_symlinks=False):
                    yield Path(entry.path)
    except OSError:
        return


def changed_at(path: Path) -> float | None:
    """Return when a recording was last written; None if the folder is no recording."""
    for name in (RunFile.STATES, RunFile.INFO):
        try:
            found = os.stat(path / name, follow_symlinks=False)
        except OSError:
            continue
        return found.st_mtime
    try:
        with os.scandir(path) as entries:
            traces = [
                entry.stat(follow_symlinks=False).st_mtime
                for _, entry in zip(range(100), entries, strict=False)
                if entry.name.endswith(_TRACE)
            ]
    except OSError:
        return None
    return max(traces, default=None)


def _id_of(path: Path) -> str:
    return sha256(os.fsencode(path.resolve())).hexdigest()[:24]


def _read(path: Path) -> dict[str, Any]:
    info = read_run(path) if is_small(path / RunFile.INFO, MOST_INFO_BYTES) else RunInfo()
    tool, story, length_s = printable(info.description)[:_LONGEST], "", None
    if not is_small(path / RunFile.STATES, MOST_TABLE_BYTES):
        there = (path / RunFile.STATES).exists()
        story = "long: open it" if there else "only traces: open it"
    elif (path / RunFile.EVENTS).exists() and not is_small(path / RunFile.EVENTS, MOST_TABLE_BYTES):
        story = "long: open it"
    else:
        try:
            log = read_states(path / RunFile.STATES)
            story = read_story(log, info).verdict
            length_s = round(log.rows[-1].time_s, 1) if log.rows else 0.0
        except BROKEN:
            story = "its states cannot be read: open it"
    return {"tool": tool, "story": printable(story)[:_LONGEST], "length_s": length_s}


def is_small(path: Path, most: int) -> bool:
    """Return whether the path is a regular file of at most this many bytes."""
    try:
        found = os.stat(path, follow_symlinks=False)
    except OSError:
        return False
    return stat.S_ISREG(found.st_mode) and found.st_size <= most
