"""What a plug-in needs, compared with what is installed: PEP 508 and 440, as far as plug-ins use them."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from end_effector_hal._extras import version_of
from end_effector_hal.vocabulary import printable

_LONGEST = 100
"""Longest version, and longest part of a requirement in a message, characters."""
_NEED = re.compile(r"([\w.-]+)\s*(?:\[[^]]*\])?\s*\(?([^()@;]*)\)?\s*(@.*)?", re.ASCII)
_CLAUSE = re.compile(r"(~=|==|!=|<=|>=|<|>)\s*([\w.!+-]+?)(\.\*)?", re.ASCII)
_VERSION = re.compile(r"v?(?:(\d+)!)?(\d+(?:\.\d+)*)[-_.]?([a-z]*)[-_.]?(\d*)[\w.-]*(?:\+.*)?", re.ASCII)
_PHASES = {
    "dev": -4, "a": -3, "alpha": -3, "b": -2, "beta": -2, "c": -1, "rc": -1, "pre": -1, "": 0, "post": 1,
}  # fmt: skip
_COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq, "!=": operator.ne, "<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt,
}  # fmt: skip


def unmet(requirements: Iterable[str]) -> str:
    """Return what is not installed as it is required, as the end of a sentence "It needs …"; empty: all is.

    A requirement with a condition is for other machines, or for an extra: it is not compared.
    """
    for requirement in requirements:
        if ";" in requirement:
            continue
        if (match := _NEED.fullmatch(requirement.strip())) is None:
            return f"{requirement[:_LONGEST]!r}, which is no requirement"
        name, clauses = match[1], match[2].split(",") if match[2].strip() else ()
        if not (installed := version_of(name)):
            return f"{name}, which is not installed"
        if not all(_meets(installed, clause.strip()) for clause in clauses):
            return f"{printable(requirement)[:_LONGEST]}, and {installed} is installed"
    return ""


def _meets(installed: str, clause: str) -> bool:
    """Return whether a version meets a clause such as ``>=2.1``; what cannot be compared does not."""
    match = _CLAUSE.fullmatch(clause)
    found, wanted = _parsed(installed), _parsed(match[2]) if match else None
    if match is None or found is None or wanted is None:
        return False
    sign = match[1]
    if sign == "~=":
        return found.key >= wanted.key and found.is_of(wanted.epoch, wanted.release[:-1])
    if match[3]:
        return found.is_of(wanted.epoch, wanted.release) is (sign == "==")
    return _COMPARED[sign](found.key, wanted.key)


@dataclass(frozen=True)
class _Version:
    epoch: int
    release: tuple[int, ...]
    phase: tuple[int, int]

    @property
    def key(self) -> tuple[object, ...]:
        """What versions are ordered by: 1.0 is 1."""
        release = [*self.release]
        while release and release[-1] == 0:
            del release[-1]
        return self.epoch, tuple(release), self.phase

    def is_of(self, epoch: int, series: tuple[int, ...]) -> bool:
        """Whether it is a release of this series, as 2.1.3 is of 2.1."""
        padded = (*self.release, *[0] * len(series))
        return (self.epoch, padded[: len(series)]) == (epoch, series)


def _parsed(version: str) -> _Version | None:
    match = _VERSION.fullmatch(version.lower()) if len(version) <= _LONGEST else None
    if match is None or match[3] not in _PHASES:
        return None
    release = tuple(map(int, match[2].split(".")))
    return _Version(int(match[1] or 0), release, (_PHASES[match[3]], int(match[4] or 0)))
