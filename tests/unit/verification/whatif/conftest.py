"""Recorded runs of the virtual tool, and descriptions that differ from its own in one value."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.page.recorded import RecordingFiles
from end_effector_hal.verification.replay import Entry
from end_effector_hal.verification.whatif import WhatIf, what_if

Other = Callable[..., Description]


class ReadOnce(NamedTuple):
    """A recording whose records were read, for many to look at."""

    description: Description
    records: tuple[Entry, ...]

    def entries(self) -> tuple[Entry, ...]:
        return self.records


@pytest.fixture(scope="session")
def files(gripped_twice: Path) -> ReadOnce:
    read = RecordingFiles(gripped_twice)
    return ReadOnce(read.description, tuple(read.entries()))


@pytest.fixture(scope="session")
def shorter(files: ReadOnce, tmp_path_factory: pytest.TempPathFactory) -> WhatIf:
    """With a time-out of the bottom vacuum of 0.25 s."""
    path = tmp_path_factory.mktemp("shorter") / "other.yaml"
    path.write_text(profile_path().read_text().replace("timeout_s: 5.0", "timeout_s: 0.25"))
    return what_if(files.entries(), files.description, load(path))


@pytest.fixture
def other(tmp_path: Path) -> Other:
    """The shipped tool with some of its text exchanged."""

    def make(*changes: tuple[str, str]) -> Description:
        text = profile_path().read_text()
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / "other.yaml"
        path.write_text(text)
        return load(path)

    return make
