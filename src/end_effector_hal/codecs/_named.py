"""An exception of somebody else's, in words."""

from __future__ import annotations

LONGEST = 200


def named(error: BaseException) -> str:
    """Its type, and what it says if that can be said: printable, in one line, at most 200 characters."""
    try:
        text = "".join(each if each.isprintable() else " " for each in str(error))[:LONGEST].strip()
    except BaseException:  # noqa: BLE001 its author's code as well
        text = ""
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
