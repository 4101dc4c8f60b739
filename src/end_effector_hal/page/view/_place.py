"""The position of an edge within the UPPAAL file, independent of the file's path."""

from __future__ import annotations


def in_file(where: str) -> str:
    """Return ``line:column`` of ``file:line:column``: the file's path may differ on the program's machine."""
    return ":".join(where.rsplit(":", 2)[1:])
