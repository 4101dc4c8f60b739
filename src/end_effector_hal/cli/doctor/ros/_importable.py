"""Whether Python finds a package here."""

from __future__ import annotations

import importlib.util


def is_importable(name: str) -> bool:
    """Of a module that may be in a package that is absent; nothing is imported but the packages around it."""
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        return False
