"""The random token of a client: by it the owner knows the one that comes back from another of the same name.

A pid does not say that: in PID namespaces of their own, as in containers, all clients have pid 0 for the owner.
"""

from __future__ import annotations

import re
import secrets
from typing import TypeGuard

_TOKEN = re.compile("[0-9a-f]{32}")


def make_token() -> str:
    """One that nobody else has."""
    return secrets.token_hex(16)


def is_token(given: object) -> TypeGuard[str]:
    """Whether it is 32 digits from 0 to f."""
    return isinstance(given, str) and _TOKEN.fullmatch(given) is not None
