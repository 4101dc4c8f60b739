"""The random token of a client: it tells a client that connects again from another one of the same name.

A pid cannot do that: the arbiter sees pid 0 for every client in a PID namespace of its own, as in a container.
"""

from __future__ import annotations

import re
import secrets
from typing import TypeGuard

_TOKEN = re.compile("[0-9a-f]{32}")


def make_token() -> str:
    """A new token."""
    return secrets.token_hex(16)


def is_token(given: object) -> TypeGuard[str]:
    """Whether it is 32 digits from 0 to f."""
    return isinstance(given, str) and _TOKEN.fullmatch(given) is not None
