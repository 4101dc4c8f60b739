"""Records in a file of fixed size: the last whole one is valid, and the file shows if a later one was begun.

Two slots are written in turn. Each record has a generation number and a checksum. If a record was begun and not
finished (the process died, the write was torn), the record before it is *outdated*: it is whole, but something has
happened since.
"""

from __future__ import annotations

import errno
import os
import struct
from enum import Enum
from typing import NamedTuple
from zlib import crc32

from end_effector_hal.arbiter.records._storage import Storage

MAGIC = b"EEHALREC"
_HEADER = struct.Struct("<8sQII")
"""The header's fields: magic, generation, payload length, and checksum of generation, length and payload."""
SLOT = 1 << 18
"""Size of a slot, bytes; a record that does not fit is refused."""
_UNFINISHED = 0xFFFFFFFF
"""Value of the length field in a record that was only begun."""
_NEVER_WRITTEN = _HEADER.pack(MAGIC, 0, _UNFINISHED, 0)


class Standing(Enum):
    """The condition of the records found in a file."""

    ABSENT = "absent"
    WHOLE = "whole"
    OUTDATED = "outdated"
    """There is a whole record; a later one was begun and not finished, or may have been lost."""
    DAMAGED = "damaged"
    """The file has content, but no whole record."""


class FoundRecord(NamedTuple):
    """The last whole record of a file.

    Attributes:
        standing: how far the record can be trusted.
        payload: content of the record; empty if there is none.
        generation: number of the record; 0 if there is none.
    """

    standing: Standing
    payload: bytes = b""
    generation: int = 0


class RecordFile:
    """Keeps the last record in a file. Every method may raise OSError and may be called again after it.

    Args:
        storage: the file.
    """

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self._generation = 0
        self._made = self._begun = self._foul = False

    def read(self) -> FoundRecord:
        """Return the last record of an earlier process."""
        content = self._storage.read()
        self._made = len(content) == 2 * SLOT
        found = _read(content)
        if found.standing is Standing.WHOLE and not self._made:
            found = found._replace(standing=Standing.OUTDATED)  # a part of the file has gone
        self._generation = found.generation
        self._foul = found.standing is Standing.DAMAGED
        return found

    @property
    def next_generation(self) -> int:
        """The generation number of the record that `keep` writes next."""
        return self._generation + 1

    def begin(self) -> None:
        """Mark the last record as outdated until the next `keep`, because a change is about to happen."""
        if self._made and not self._begun:
            self._write(self._generation + 1, _HEADER.pack(MAGIC, self._generation + 1, _UNFINISHED, 0))
            self._begun = True

    def keep(self, payload: bytes, *, synced: bool = False) -> None:
        """Write a new last record; if ``synced``, it survives a power loss once this method returns."""
        if len(payload) > SLOT - _HEADER.size:
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        record = _record(self._generation + 1, payload)
        if self._made:
            self._write(self._generation + 1, record)
            if self._foul:
                self._write(self._generation, _NEVER_WRITTEN)
            if synced:
                self._storage.sync()
        else:
            slots = [_NEVER_WRITTEN, record] if self._generation % 2 == 0 else [record, _NEVER_WRITTEN]
            content = b"".join(slot.ljust(SLOT, b"\0") for slot in slots)
            self._storage.create(content, 2 * SLOT)
            self._made = True
        self._generation += 1
        self._begun = self._foul = False

    def remove(self) -> None:
        """Delete the file; the next record creates a new one."""
        self._storage.remove()
        self._made = False

    def close(self) -> None:
        """Close the file."""
        self._storage.close()

    def _write(self, generation: int, data: bytes) -> None:
        try:
            self._storage.write(generation % 2 * SLOT, data)
        except OSError as error:
            self._storage.close()  # to be opened again: the disk may have come back elsewhere
            self._made = error.errno != errno.ENOENT
            raise


def _record(generation: int, payload: bytes) -> bytes:
    return _HEADER.pack(MAGIC, generation, len(payload), _checksum(generation, payload)) + payload


def _checksum(generation: int, payload: bytes) -> int:
    return crc32(payload, crc32(struct.pack("<QI", generation, len(payload))))


def _read(content: bytes) -> FoundRecord:
    slots = [_read_slot(content[at : at + SLOT]) for at in (0, SLOT)]
    whole = max((slot for slot in slots if slot.standing is Standing.WHOLE), key=_generation, default=None)
    if whole is None:
        empty = all(slot.standing is Standing.ABSENT for slot in slots)
        return FoundRecord(Standing.ABSENT if empty else Standing.DAMAGED)
    for slot in slots:
        # both slots are written when the file is made: one that is empty was lost
        lost = slot.standing is Standing.ABSENT
        if lost or (slot.standing is Standing.DAMAGED and slot.generation > whole.generation):
            return whole._replace(standing=Standing.OUTDATED)
    return whole


def _read_slot(slot: bytes) -> FoundRecord:
    if slot == bytes(len(slot)):
        return FoundRecord(Standing.ABSENT)
    if len(slot) < _HEADER.size or not slot.startswith(MAGIC):
        return FoundRecord(Standing.DAMAGED, b"", _UNKNOWN)
    _, generation, length, checksum = _HEADER.unpack_from(slot)
    payload = slot[_HEADER.size : _HEADER.size + length]
    if len(payload) < length or checksum != _checksum(generation, payload):
        return FoundRecord(Standing.DAMAGED, b"", generation)
    return FoundRecord(Standing.WHOLE, payload, generation)


def _generation(slot: FoundRecord) -> int:
    return slot.generation


_UNKNOWN = 1 << 64
"""Generation of a slot that cannot be read; it counts as later than every readable one."""
