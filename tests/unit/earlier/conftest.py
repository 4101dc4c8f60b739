"""Files that version 0.1 wrote, before its packages were renamed: they are read as they are.

``run``: a grip that was cancelled, by `eehal demo --no-ros --only cancel`. ``arbiter``: the virtual chip, the session
record and its generation of a line arbiter that was killed in the third step of a grip; and the journal of one that
started after it without a session record, and ended in order.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

ARCHIVE = Path(__file__).parent / "version_0_1.tar.xz"


@pytest.fixture
def earlier(tmp_path: Path) -> Path:
    shutil.unpack_archive(ARCHIVE, tmp_path)
    return tmp_path
