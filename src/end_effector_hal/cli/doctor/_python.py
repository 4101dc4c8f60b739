"""Checks the interpreter, this distribution and its dependencies."""

from __future__ import annotations

import os
import re
import sys
from importlib import metadata

from end_effector_hal._extras import DISTRIBUTION, command_for, extras

from ._check_result import CheckedPart, CheckResults

_NEEDED_BY = {
    "bags": "`eehal import`",
    "cluster": "work that is shared out to other machines (`--scheduler`)",
    "lab": "figures, simulations and trials",
    "modbus": "the codecs modbus-rtu-*",
    "page": "`eehal page`",
    "recordings": "`eehal replay`, `eehal page RECORDING` and the index of a trace",
}
_DEBIAN = "/usr/lib/python3/dist-packages"
_say = CheckedPart("python")


def look_at_python() -> CheckResults:
    """Check the version, the packages, and an environment variable that breaks them."""
    version = ".".join(map(str, sys.version_info[:3]))
    yield _say.ok(f"Python {version} at {sys.executable}")
    try:
        own = metadata.distribution(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        yield _say.missing(f"{DISTRIBUTION} is not installed here", "pip install . in a virtual environment")
        return
    absent = sorted(name for name in _needed(own) if not _installed(name))
    if absent:
        yield _say.missing(
            f"{DISTRIBUTION} {own.version}, without {', '.join(absent)}", f"pip install {' '.join(absent)}"
        )
    else:
        yield _say.ok(f"{DISTRIBUTION} {own.version}")
    for extra, packages in extras().items():
        if not all(_installed(name) for name in packages):
            yield _say.warning(
                f"the extra {extra} is not installed ({', '.join(packages)})",
                f"Needed by {_NEEDED_BY[extra]} only: {command_for(extra)}",
            )
    if _DEBIAN in os.environ.get("PYTHONPATH", "").split(":"):
        yield _say.warning(
            f"PYTHONPATH names {_DEBIAN}: Debian's packages hide newer ones of this environment",
            "Take it out; make the environment with python3 -m venv --system-site-packages.",
        )


def _needed(own: metadata.Distribution) -> list[str]:
    names = []
    for requirement in own.requires or []:
        name = re.match(r"[\w.-]+", requirement)
        if name and "extra ==" not in requirement:
            names.append(name[0])
    return names


def _installed(name: str) -> bool:
    try:
        metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return False
    return True
