"""The journal of version 0.1: a text file, in each line a checksum and the whole state of the line arbiter of then."""

from __future__ import annotations

import re
from collections.abc import Mapping
from zlib import crc32

from end_effector_hal.arbiter._json import read_json
from end_effector_hal.arbiter.rules import read_faults
from end_effector_hal.errors import UsageError

_RECORD = re.compile(rb"[0-9a-f]{8} \{")


def read_old_journal(content: bytes) -> Mapping[str, str] | None:
    """The faults in its last whole record; None: this is not such a file.

    Its last wills are not read: nothing says whether they still fit what is held.
    """
    if not _RECORD.match(content):
        return None
    faults: Mapping[str, str] = {}
    for line in content.split(b"\n"):
        given, _, text = line.partition(b" ")
        if given != b"%08x" % crc32(text):
            continue
        try:
            faults = read_json(text, lambda given: read_faults(given["faults"]))
        except UsageError:
            continue
    return faults
