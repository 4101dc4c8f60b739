"""The journal of version 0.1: a text file, in each line a checksum and everything that the owner knew."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from zlib import crc32

from end_effector_hal.arbiter.rules import read_faults
from end_effector_hal.errors import UsageError

_RECORD = re.compile(rb"[0-9a-f]{8} \{")


def read_old_journal(content: bytes) -> Mapping[str, str] | None:
    """The faults in its last whole record; None: it is no such file.

    Its last wills are not read: whether they still fit what is held cannot be told.
    """
    if not _RECORD.match(content):
        return None
    faults: Mapping[str, str] = {}
    for line in content.split(b"\n"):
        given, _, text = line.partition(b" ")
        if given != b"%08x" % crc32(text):
            continue
        try:
            faults = read_faults(json.loads(text)["faults"])
        except (ValueError, KeyError, TypeError, UsageError, RecursionError):
            continue
    return faults
