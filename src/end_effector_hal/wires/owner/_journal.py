"""The owner's memory on disk: it survives the death of the owner, and its faults survive the loss of power.

Each record is the whole memory in a line, with a checksum in front; the last whole one counts. Whatever part of the
file is lost at its end, what is left was true at some time. What changes a fault, and the start and the end of an
owner, are on the disk before anybody is told of it (fsync); a will is not waited for: power that goes takes the
lines with it.
"""

from __future__ import annotations

import json
import logging
import os
from dataclasses import replace
from pathlib import Path
from zlib import crc32

from end_effector_hal.errors import UsageError
from end_effector_hal.wires.owner._memory import Memory, read_memory

_log = logging.getLogger("end_effector_hal.owner")
LONGEST = 1 << 18
"""Bytes after which the file is begun anew."""


class Journal:
    """One file. Trouble with the disk is logged once and ends nothing: an owner without memory still owns.

    Args:
        path: the file; None: remember nothing.
    """

    def __init__(self, path: str | Path | None) -> None:
        self._path = Path(path) if path else None
        self._fd, self._size = -1, 0
        self._last: Memory | None = None
        self.before = read_journal(self._path) if self._path else Memory()
        """What an earlier owner has left."""

    def keep(self, memory: Memory) -> None:
        """Remember it, if it is something else than before."""
        if self._path is None or memory == self._last:
            return
        known, self._last = self._last, memory
        lasting = known is None or (known.faults, known.clean) != (memory.faults, memory.clean)
        record = _record(memory)
        try:
            if self._fd < 0 or self._size > LONGEST:
                self._begin(self._path, record)
                return
            self._size += os.write(self._fd, record)
            if lasting:
                os.fsync(self._fd)
        except OSError as error:
            _log.error("the line owner's journal %s cannot be written: %s", self._path, error.strerror)
            self._path = None
            self._close()

    def close(self) -> None:
        """The owner ends in order."""
        if self._last is not None:
            self.keep(replace(self._last, clean=True))
        self._close()

    def _begin(self, path: Path, record: bytes) -> None:
        """A new file in the place of the old one, in one step; a record that was torn goes with the old one."""
        self._close()
        fresh = path.with_name(f".{path.name}.new")
        fd = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o640)
        try:
            os.write(fd, record)
            os.fsync(fd)
            os.rename(fresh, path)
        except BaseException:
            os.close(fd)
            raise
        self._fd, self._size = fd, len(record)
        folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def _close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


def read_journal(path: Path) -> Memory:
    """The last memory that stands whole in a file; an empty one if there is none."""
    memory = Memory()
    try:
        lines = path.read_bytes().split(b"\n")
    except FileNotFoundError:
        return memory
    except OSError as error:
        _log.error("the line owner's journal %s cannot be read: %s", path, error.strerror)
        return memory
    for line in lines[:-1]:
        try:
            memory = _read(line)
        except UsageError as error:
            _log.warning("%s ends early: %s", path, error)
            break
    return memory


def _record(memory: Memory) -> bytes:
    text = json.dumps(memory.as_json(), separators=(",", ":")).encode()
    return b"%08x %s\n" % (crc32(text), text)


def _read(line: bytes) -> Memory:
    given, _, text = line.partition(b" ")
    if given != b"%08x" % crc32(text):
        raise UsageError("a record is damaged.")
    try:
        return read_memory(json.loads(text))
    except ValueError as error:
        raise UsageError(f"a record cannot be read: {error}") from error
