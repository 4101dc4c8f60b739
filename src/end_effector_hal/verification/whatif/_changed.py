"""Another description from a text that somebody typed: a whole one, or values that differ from the recorded one."""

from __future__ import annotations

import atexit
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, did_you_mean
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.runtime.boundary import MODEL, whole

MOST_TEXT = 200_000
"""Bytes; a description has some thousand."""
NAME = "what-if.yaml"
MOST_CHANGES = 20
_VALUE = re.compile(r"([A-Za-z_]\w*(?:\.\w+)+)\s*[:=]\s*(\S.*)")
_TODO = "Write a line for each value, such as `actuators.cylinder.timeout_s: 2`, or a whole description."


def changed_description(text: str, recorded: Description) -> Description:
    """A description from a text; its automata are those of the recording, its files there until this process ends.

    Args:
        text: lines such as ``actuators.cylinder.timeout_s: 2``, or a whole description in YAML.
        recorded: what the values differ from.

    Raises:
        DescriptionError: it is no valid description, with every fault.
        UsageError: there is no such key, or nothing is said.
    """
    if len(text.encode()) > MOST_TEXT:
        raise UsageError(f"This is longer than {MOST_TEXT} bytes.", todo=_TODO)
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    if not lines:
        raise UsageError("Nothing is said.", todo=_TODO)
    values = [_VALUE.fullmatch(line.partition(" #")[0].strip()) for line in lines]
    if all(values):
        tree = json.loads(whole(recorded))
        for found in values:
            assert found is not None
            _put(tree, found[1].split("."), found[2])
        text = json.dumps(tree, indent=1, ensure_ascii=False)
    folder = Path(mkdtemp(prefix="eehal-what-if-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / NAME).write_text(text, encoding="utf-8")
    (folder / MODEL).write_bytes(recorded.automata_path.read_bytes())
    description = load_tool(folder / NAME)
    if description.automata_path != folder / MODEL:
        raise UsageError(
            "The automata are those of the recording: no other file can be named here.",
            where="automata.file",
            todo="`eehal replay --description FILE` takes a description with automata of its own.",
        )
    return description


def changes(recorded: Description, other: Description) -> tuple[str, ...]:
    """Values that differ, such as ``actuators.cylinder.timeout_s: 5.0 → 2.0``, without how the wires are reached."""
    ours, theirs = (dict(_leaves(each.model_dump(mode="json", by_alias=True))) for each in (recorded, other))
    found = [
        f"{key}: {_said(ours.get(key))} → {_said(theirs.get(key))}"
        for key in dict.fromkeys((*ours, *theirs))
        if ours.get(key) != theirs.get(key) and not key.startswith(("lines.", "link.port", "automata.file"))
    ]
    return (
        *found[:MOST_CHANGES],
        *([f"and {len(found) - MOST_CHANGES} more"] if len(found) > MOST_CHANGES else []),
    )


def _leaves(tree: Any, path: str = "") -> Iterator[tuple[str, object]]:
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else None
    if items is None:
        yield path, tree
        return
    for key, value in items:
        yield from _leaves(value, f"{path}.{key}" if path else str(key))


def _said(value: object) -> str:
    return "none" if value is None else str(value)[:60]


def in_short(error: ReportedError) -> str:
    """What is wrong with such a text, without where it was put."""
    return re.sub(r"\S*/eehal-what-if-[^/]*/", "", str(error))


def _put(tree: Any, keys: list[str], said: str) -> None:
    place = tree
    for number, key in enumerate(keys):
        keyed: Any = place
        if isinstance(place, list):
            if not key.isdecimal() or len(key) > 4 or int(key) >= len(place):
                raise UsageError(f"There is no {'.'.join(keys[: number + 1])}.", todo=_TODO)
            keyed, index = place, int(key)
        elif not isinstance(place, dict) or key not in place:
            near = did_you_mean(key, place) if isinstance(place, dict) else ""
            raise UsageError(f"There is no {'.'.join(keys[: number + 1])}.", todo=near or _TODO)
        step: Any = index if isinstance(keyed, list) else key
        if number == len(keys) - 1:
            place[step] = _value(said)
        else:
            place = place[step]


def _value(said: str) -> object:
    try:
        found: object = json.loads(said)
    except ValueError:
        return said.strip("'\"")
    return found
