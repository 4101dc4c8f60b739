"""Finds out whether Python can import a package."""

from __future__ import annotations

import importlib.util


def is_importable(name: str) -> bool:
    """Return whether a module can be imported, even if its package is absent; only the packages that contain it are
    imported.
    """
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        return False
