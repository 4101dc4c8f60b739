"""Opening a bag: which format it has is seen in its first bytes."""

from __future__ import annotations

import re
from pathlib import Path

from end_effector_hal.errors import UsageError

from ._bag_message import Bag
from ._mcap import McapBag
from ._rosbag1 import Rosbag1
from ._rosbag2 import Rosbag2

MAGIC_ROS1, MAGIC_MCAP, MAGIC_SQLITE = b"#ROSBAG", b"\x89MCAP0\r\n", b"SQLite format 3\0"
_MESSAGES_COMPRESSED = re.compile(rb"^\s*compression_mode:\s*['\"]?message\b", re.IGNORECASE | re.MULTILINE)
_WHAT = "Name a .bag file, a folder that rosbag2 wrote, or an .mcap file."


def open_bag(path: Path) -> Bag:
    """Open a bag; raises UsageError for what is none, or cannot be read at all."""
    try:
        if path.is_dir():
            return _open_folder(path)
        if not path.is_file():
            raise UsageError("There is no such bag.", where=str(path), todo=_WHAT)
        with path.open("rb") as file:
            head = file.read(len(MAGIC_SQLITE))
        if head.startswith(MAGIC_MCAP):
            return McapBag((path,))
        if head.startswith(MAGIC_SQLITE):
            return Rosbag2((path,))
        if head.startswith(MAGIC_ROS1):
            return Rosbag1(path)
    except OSError as error:
        raise UsageError(f"Cannot be read: {error.strerror or error}.", where=str(path)) from None
    raise UsageError("This is not a bag.", where=str(path), todo=_WHAT)


def _open_folder(path: Path) -> Bag:
    """The files decide, so that a folder without its metadata.yaml, as a killed recorder leaves it, is read as well."""
    metadata = path / "metadata.yaml"
    told = metadata.read_bytes() if metadata.exists() else b""
    files = _numbered(path, ".mcap")
    if files and not _MESSAGES_COMPRESSED.search(told):
        return McapBag(files)
    if told:
        return Rosbag2((path,))
    if files := _numbered(path, ".db3"):
        return Rosbag2(files)
    raise UsageError("There is no bag in this folder.", where=str(path), todo=_WHAT)


def _numbered(folder: Path, suffix: str) -> tuple[Path, ...]:
    """The files of a folder in the order of writing: ``NAME_0``, ``NAME_1``, … ``NAME_10``."""

    def key(path: Path) -> list[tuple[int, str]]:
        return [
            (int(each[:18]), "") if each.isdecimal() else (0, each) for each in re.split(r"(\d+)", path.name)
        ]

    return tuple(sorted((each for each in folder.iterdir() if each.suffix == suffix), key=key))
