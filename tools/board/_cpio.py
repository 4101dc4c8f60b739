"""Archives that a kernel unpacks into memory at its start (cpio, "newc"); all files belong to root."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from typing import BinaryIO

MAGIC, TRAILER = "070701", "TRAILER!!!"


def write_archive(folder: Path, file: BinaryIO) -> None:
    """Append all files of a folder; a file may contain several archives in sequence."""
    _pad(file)
    for number, path in enumerate(sorted(folder.rglob("*")), start=1):
        status = path.lstat()
        if stat.S_ISLNK(status.st_mode):
            content = os.readlink(path).encode()
        elif stat.S_ISREG(status.st_mode):
            content = path.read_bytes()
        elif stat.S_ISDIR(status.st_mode):
            content = b""
        else:
            continue  # a device: the kernel makes them itself
        _entry(file, str(path.relative_to(folder)), content, number, status.st_mode, int(status.st_mtime))
    _entry(file, TRAILER, b"", 0, 0, 0)


def _entry(file: BinaryIO, name: str, content: bytes, number: int, mode: int, mtime: int) -> None:
    links = 1
    fields = [number, mode, 0, 0, links, mtime, len(content), 0, 0, 0, 0, len(name.encode()) + 1, 0]
    file.write((MAGIC + "".join(f"{field:08x}" for field in fields) + name).encode() + b"\0")
    _pad(file)
    file.write(content)
    _pad(file)


def _pad(file: BinaryIO) -> None:
    file.write(bytes(-file.tell() % 4))


if __name__ == "__main__":
    with Path(sys.argv[2]).open("wb") as archive:
        write_archive(Path(sys.argv[1]), archive)
