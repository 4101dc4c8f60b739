"""Reads the text of a YAML file, or says in one fault why it cannot be read."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description._fault import Fault, did_you_mean

from ._yaml import position

LIMIT = 256 * 1024
NAME = "end_effector.yaml"


def read_text(path: Path) -> str | Fault:
    """Return the text of a file, or a fault if it cannot be read."""
    try:
        if path.is_fifo() and not str(path).startswith(
            ("/dev/", "/proc/")
        ):  # there a shell has put it, with a writer
            return _unread("this is a named pipe, not a file", "the path of a description")
        with path.open("rb") as stream:
            data = stream.read(LIMIT + 1)
    except FileNotFoundError:
        return _unread("there is no such file", "the path of a description", _neighbours(path))
    except IsADirectoryError:
        inside = f"write {path / NAME}" if (path / NAME).is_file() else ""
        return _unread("this is a directory", "the path of a description", inside)
    except PermissionError:
        return _unread("the file may not be read", "read permission for this user")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        return _unread(f"the file cannot be read: {reason}", "the path of a description")
    if len(data) > LIMIT:
        return _unread("the file is too large", f"a description of at most {LIMIT // 1024} KiB")
    return _decode(data)


def _decode(data: bytes) -> str | Fault:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8-sig", "replace")
        line, column = position(before, len(before))
        found = f"byte 0x{data[error.start]:02X}"
        return Fault(line, column, "EE-201", "this is not text", found, "YAML in UTF-8")
    return text


def _unread(what: str, expected: str, hint: str = "") -> Fault:
    return Fault(0, 0, "EE-201", what, "", expected, hint)


def _neighbours(path: Path) -> str:
    try:
        return did_you_mean(path.name, [each.name for each in path.parent.iterdir() if each.is_file()])
    except OSError:
        return ""
