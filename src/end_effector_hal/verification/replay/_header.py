"""Check the header of a trace against the other content of the trace; nothing in it is trusted."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime
from hashlib import sha256

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, hash_of
from end_effector_hal.runtime.boundary import DESCRIPTION, MODEL, STATE
from timed_automata.monitor import Objection

from ._load import ProgramTrace

STARTED_S = 60.0
"""Largest difference between the time of day in the header and that of its message, s; a clock may be set between the
two.
"""


def header_objections(trace: ProgramTrace, tool: Description) -> Iterator[Objection]:
    """Yield objections where the description, the automata or the other records contradict a header.

    Args:
        trace: one segment.
        tool: the description in the trace.

    Raises:
        UsageError: a record has no time.
    """
    for what in (*_of_files(trace, tool), *_of_constants(trace, tool), *_of_segments(trace)):
        yield Objection(trace.header.at, "no run", f"The header says {what}.")
    yield from _of_times(trace)


def _of_files(trace: ProgramTrace, tool: Description) -> Iterator[str]:
    header, files = trace.header, trace.file.attachments
    if header.description != tool.name:
        yield f"that the tool is {header.description!r}, and its description in the trace is of {tool.name!r}"
    model = sha256(files[MODEL]).hexdigest()[:12]
    if header.model != model:
        yield f"that the UPPAAL file is {header.model!r}, and the one in the trace is {model!r}"
    found = _hash(files[DESCRIPTION], files[MODEL])
    if header.hash != found:
        yield f"that description and automata are {header.hash!r}, and those in the trace are {found!r}"


def _hash(description: bytes, model: bytes) -> str:
    try:
        return hash_of(json.loads(description), model)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return "not as the program writes them"


def _of_constants(trace: ProgramTrace, tool: Description) -> Iterator[str]:
    """Yield faults if the constants are not those that the description defines."""
    recorded, expected = trace.header.constants, model_constants(tool)
    for name in sorted(recorded.keys() | expected.keys()):
        if name not in expected:
            yield f"that {name} = {recorded[name]!r}, and the automata have no such constant"
        elif name not in recorded:
            yield f"nothing of {name}, which the description makes {expected[name]!r}"
        elif _json(recorded[name]) != _json(expected[name]):
            yield f"that {name} = {recorded[name]!r}, and the description in the trace makes it {expected[name]!r}"


def _json(value: object) -> str:
    return json.dumps(value, default=str)


def _of_segments(trace: ProgramTrace) -> Iterator[str]:
    header = trace.header
    if header.segment < 1:
        yield f"that this is segment {header.segment}, and they are counted from 1 on"
    if header.segment == 1 and any(record.kind == STATE for record in trace.file.records):
        yield "that this is the first segment, and there is a state with which a later one begins"
    if header.follows and header.segment == 1:
        yield "that the first segment follows another one"
    if header.follows and header.gap is not None:
        yield "that nothing is missing before this segment, and that records are"
    if header.gap is not None and (header.gap.since > header.at or header.gap.records < 0):
        yield "that the gap before this segment begins after it, or has a negative length"


def _of_times(trace: ProgramTrace) -> Iterator[Objection]:
    """Yield objections if message times are not those of their records plus one constant offset."""
    header, shifts = trace.header, dict[int, int]()
    for number, record in enumerate(trace.file.records):
        if record.day_us is not None:
            shifts[number] = record.day_us - trace.content(number)["at"]
    if not shifts:
        return
    (usual, _), *_ = Counter(shifts.values()).most_common(1)
    for number, shift in shifts.items():
        if shift != usual:
            kind, at = trace.file.records[number].kind, trace.content(number)["at"]
            what = f"Record {number} ({kind}) has another time than its message, by {abs(shift - usual)} µs."
            yield Objection(at, "no run", what)
    day_us = trace.file.records[0].day_us
    if day_us is None or header.segment != 1 or header.gap is not None:
        return  # the clock may have been set since the program began
    try:
        started = datetime.fromisoformat(header.started)
    except ValueError:
        yield Objection(header.at, "no run", f"The start time in the header is invalid: {header.started!r}.")
        return
    started = started if started.tzinfo else started.replace(tzinfo=UTC)
    if abs(started.timestamp() - day_us / 1e6) > STARTED_S:
        what = f"The start time in the header, {header.started}, is not the time of day of its message."
        yield Objection(header.at, "no run", what)
