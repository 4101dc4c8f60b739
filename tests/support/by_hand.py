"""Tests that are played when they are asked for: they need what takes minutes to make."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest


def only_when_asked(
    items: Iterable[pytest.Item],
    folder: Path,
    fixtures: set[str],
    *,
    asked: bool,
    timeout_s: int,
    reason: str,
) -> None:
    """Mark the tests of a folder that use one of these fixtures; skip them unless ``asked``, for this reason."""
    for item in items:
        if item.path.parent == folder and fixtures & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.wall)
            item.add_marker(pytest.mark.timeout(timeout_s))
            if not asked:
                item.add_marker(pytest.mark.skip(reason=reason))
