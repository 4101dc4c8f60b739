"""Writes all that a bug report needs into one file, without names, private paths and secrets."""

from __future__ import annotations

import getpass
import os
import platform
import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from end_effector_hal._extras import DISTRIBUTION, version_of
from end_effector_hal.cli._options import write_whole
from end_effector_hal.cli._output import json_text

from ._check_result import CheckResult

VARIABLES = (
    "LANG", "LC_ALL", "PYTHONPATH", "RMW_IMPLEMENTATION", "ROS_DISTRO", "ROS_DOMAIN_ID", "ROS_VERSION", "SHELL", "TERM",
)  # fmt: skip
"""The only environment variables in a report; any other may contain a secret."""
LONGEST = 200_000
"""Largest length of a description in a report, characters."""
_SECRETS = (
    (re.compile(r"(?<=://)[^/@\s]+@"), ""),
    (
        re.compile(r"(?i)\b((?:[\w-]*(?:password|passwd|secret|token|api[_-]?key))[\"']?\s*[=:]\s*)\S+"),
        r"\1<removed>",
    ),
)


_ABSOLUTE = re.compile(r"(?<![\w.~…/-])/([\w.-]+)((?:/[\w.@+-]+)+)")
_OF_THE_SYSTEM = (
    "bin",
    "boot",
    "dev",
    "etc",
    "lib",
    "lib64",
    "opt",
    "proc",
    "run",
    "sbin",
    "sys",
    "usr",
    "var",
)


def write_report(
    file: Path, description: Path, answer: Mapping[str, object], findings: Sequence[CheckResult]
) -> None:
    """Write the report as JSON if the file name ends in .json, else as text.

    Args:
        file: the report; it is written completely or not at all.
        description: the description of the tool that was examined.
        answer: the answer of the command, as ``--json`` prints it.
        findings: the same findings for people.

    Raises:
        UsageError: the file cannot be written.
    """
    facts: dict[str, object] = {
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        DISTRIBUTION: _version(DISTRIBUTION),
        "python": sys.version,
        "platform": platform.platform(),
        "command": " ".join(sys.argv[1:]),
    }
    parts: dict[str, str | dict[str, str]] = {
        "environment": {name: os.environ[name] for name in VARIABLES if name in os.environ},
        "packages": _packages(),
        "description": _text_of(description),
    }
    if file.suffix == ".json":
        cleaned = {name: _cleaned(value) for name, value in {**facts, **answer, **parts}.items()}
        text = json_text(cleaned, indent=2) + "\n"
    else:
        lines = "\n".join(
            [
                *(f"{name}: {value}" for name, value in facts.items()),
                "",
                *(line for finding in findings for line in finding.lines),
                *(line for name, part in parts.items() for line in ("", f"## {name}", *_lines(part))),
                "",
            ]
        )
        text = without_secrets(lines)
    write_whole(file, text.encode())


def without_secrets(text: str) -> str:
    """Return a text without the names of this user and this machine, their folders, and text that looks
    like a secret.
    """
    home = str(Path.home())
    if len(home) > 1:
        text = re.sub(rf"{re.escape(home)}(?![\w.-])", "~", text)
    text = re.sub(r"/home/[^/\s\"']+", "~", text)
    text = _ABSOLUTE.sub(_shortened, text)
    for name, shown in ((_user(), "<user>"), (platform.node(), "<host>")):
        if len(name) > 2 and name not in ("root", "localhost"):
            text = re.sub(rf"(?<![\w-]){re.escape(name)}(?![\w-])", shown, text)
    for pattern, instead in _SECRETS:
        text = pattern.sub(instead, text)
    return text


def _shortened(found: re.Match[str]) -> str:
    """Shorten a path to its last name, because folder names reveal private details. ROS names and paths of the system
    stay.
    """
    first, rest = found[1], found[2]
    if first in _OF_THE_SYSTEM or not Path("/", first).is_dir():
        return found[0]
    return f"…/{rest.rpartition('/')[2]}"


def _lines(part: str | Mapping[str, str]) -> list[str]:
    return (
        part.splitlines() if isinstance(part, str) else [f"{name}: {value}" for name, value in part.items()]
    )


def _cleaned(value: object) -> object:
    """Clean every text inside a value; this happens before the value becomes JSON, whose syntax must stay intact."""
    if isinstance(value, str):
        return without_secrets(value)
    if isinstance(value, Mapping):
        return {name: _cleaned(each) for name, each in value.items()}
    return [_cleaned(each) for each in value] if isinstance(value, list) else value


def _user() -> str:
    with suppress(OSError, KeyError):  # a user id without a name, as in a container
        return getpass.getuser()
    return ""


def _version(name: str) -> str:
    return version_of(name) or "not installed"


def _packages() -> dict[str, str]:
    """Return the versions of all packages that this distribution needs, extras included."""
    needed: list[str] = []
    with suppress(metadata.PackageNotFoundError):
        needed = metadata.requires(DISTRIBUTION) or []
    names = {found[0] for each in needed if (found := re.match(r"[\w.-]+", each))} - {DISTRIBUTION}
    return {name: _version(name) for name in sorted(names)}


def _text_of(description: Path) -> str:
    try:
        with description.open(encoding="utf-8", errors="replace") as file:
            return file.read(LONGEST)
    except OSError as error:
        return f"(not readable: {error.strerror})"
