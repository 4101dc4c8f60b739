"""Rules between the numbers of a stanza, as data; the description says where they are broken."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

Pair = tuple[str, str, str]
"""``("gone_kpa", "<", "lost_kpa")``: two keys, and ``<`` or ``<=``."""

Quote = Callable[[str], str]
"""From a key to ``gone_kpa = 10 (default)``."""


class JointRule(NamedTuple):
    """Several numbers that only make sense together.

    Attributes:
        keys: of the stanza, or ``supply.refuse_kpa``: of that of the supply.
        fault: takes the name of the actuator, the number of each key, and a `Quote`; returns what is wrong and
            what is expected, or None.
    """

    keys: tuple[str, ...]
    fault: Callable[[str, Mapping[str, float], Quote], tuple[str, str] | None]
