"""What a plug-in needs, compared with what is installed."""

from __future__ import annotations

from collections.abc import Iterable

from packaging.requirements import InvalidRequirement, Requirement
from packaging.version import InvalidVersion

from end_effector_hal._extras import version_of
from end_effector_hal.vocabulary import printable

_LONGEST = 100
"""Longest part of a requirement in a message, characters."""


def unmet(requirements: Iterable[str]) -> str:
    """Return what is not installed as it is required, as the end of a sentence "It needs …"; empty: all is.

    A requirement whose condition is false here is for other machines, or for an extra.
    """
    for requirement in requirements:
        try:
            wanted = Requirement(requirement)
        except InvalidRequirement:
            return f"{requirement[:_LONGEST]!r}, which is no requirement"
        if wanted.marker is not None and not wanted.marker.evaluate({"extra": ""}):
            continue
        if not (installed := version_of(wanted.name)):
            return f"{wanted.name}, which is not installed"
        try:
            met = wanted.specifier.contains(installed, prereleases=True)
        except InvalidVersion:
            met = False
        if not met:
            return f"{printable(requirement)[:_LONGEST]}, and {installed} is installed"
    return ""
