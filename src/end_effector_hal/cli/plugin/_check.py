"""Whether a plug-in can be loaded: tried in a process of its own, which its code may end or block."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint, distributions
from pathlib import Path
from typing import Any

from end_effector_hal.errors import ReportedError
from end_effector_hal.plugins import Plugins

LONGEST_S = 60.0
_REPORT = f"import sys; from {__package__} import report; report(sys.argv[1])"
_NOUNS = {"codecs": "codec", "kinds": "kind", "commands": "command"}


def brought(entry: EntryPoint) -> str:
    """Return an entry point in words, such as ``codec gauge``."""
    sort = entry.group.rpartition(".")[2]
    return f"{_NOUNS.get(sort, sort)} {entry.name}"


def faults(folder: Path) -> Mapping[str, str]:
    """Return why an entry point of the plug-in in this folder cannot be loaded, by its words; empty: all can."""
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _REPORT, str(folder)],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, timeout=LONGEST_S, check=False,
        )  # fmt: skip
        found: dict[str, str] = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return {"": f"Its import did not end within {LONGEST_S:g} s."}
    except ValueError:
        return {"": "Its import ended the program."}
    return found


def report(folder: str) -> None:
    """Print the faults of a plug-in as JSON; what its code prints is discarded."""
    answer, nowhere = os.dup(1), os.open(os.devnull, os.O_RDWR)
    for number in (1, 2):
        os.dup2(nowhere, number)
    # before the folder of an older version of the same plug-in
    sys.path.append(folder)
    found = {}
    for distribution in distributions(path=[folder]):
        for entry in distribution.entry_points:
            try:
                _loader(entry.group)(entry.name)
            except ReportedError as error:
                found[brought(entry)] = str(error)
    os.write(answer, json.dumps(found).encode())
    os._exit(0)  # an import that did not end still runs


def _loader(group: str) -> Callable[[str], Any]:
    from end_effector_hal.codecs import get_codec
    from end_effector_hal.kinds import get_kind

    sort = group.rpartition(".")[2]
    others: Plugins[Any] = Plugins(group, sort, {}, lambda loaded: loaded, make=False)
    loaders: dict[str, Callable[[str], Any]] = {"codecs": get_codec, "kinds": get_kind}
    return loaders.get(sort, others.get)
