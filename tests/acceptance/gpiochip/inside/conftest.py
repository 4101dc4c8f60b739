"""These checks run in the guest, started by ../test_lines.py."""

from __future__ import annotations

import os

import pytest


@pytest.fixture
def tool() -> str:
    """The file of a description for this machine."""
    return os.environ["EEHAL_TOOL"]
