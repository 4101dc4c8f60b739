"""Where an edge stands in the UPPAAL file, wherever that file stands itself."""

from __future__ import annotations


def in_file(where: str) -> str:
    """``line:column`` of ``file:line:column``: the program's file may have another path than the same one here."""
    return ":".join(where.rsplit(":", 2)[1:])
