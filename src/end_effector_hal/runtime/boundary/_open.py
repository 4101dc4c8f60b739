"""Begin the trace of a program, with its header and the tool's description and automata at that time."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from secrets import token_hex

from end_effector_hal.control import model_constants
from end_effector_hal.description import Description, content_hash, socket_path
from end_effector_hal.recording import Opening, RecordingLimits, TraceWriter, product_version
from end_effector_hal.runtime.stream import (
    RELOAD_WORDS,
    SWITCH_WORDS,
    WORDS,
    RecordStream,
    program_socket,
)
from end_effector_hal.wires import now_us

from ._recorder import Observer, Recorder
from ._records import KINDS, Header

DESCRIPTION, MODEL = "description.json", "end_effector.xml"


def open_recorder(
    folder: str | Path,
    description: Description,
    *,
    at: int | None = None,
    limits: RecordingLimits | None = None,
    stream: RecordStream | None = None,
    observe: Observer | None = None,
) -> Recorder:
    """Return a recorder that writes ``hal.mcap`` and further segments, without waiting for the disk.

    Args:
        folder: the folder for the trace.
        description: the tool.
        at: the current time of the run, µs; default: that of the monotonic clock.
        limits: the recording limits of the folder.
        stream: gets the same records.
        observe: called with the same records.
    """
    at = now_us() if at is None else at
    model = description.automata_path.read_bytes()
    attachments = {DESCRIPTION: whole(description), MODEL: model}
    first = header_of(description, at)

    def header(opening: Opening) -> Header:
        return replace(
            first,
            at=opening.at,
            started=datetime.now(UTC).isoformat(),
            segment=opening.segment,
            follows=opening.follows,
            gap=opening.gap,
        )

    return Recorder(
        TraceWriter(folder, KINDS, now=at, attachments=attachments, header=header, limits=limits),
        stream,
        observe,
    )


def open_stream(description: Description) -> RecordStream:
    """Return the stream of a program, which is not served yet."""
    first = header_of(description, now_us())
    path, beside = program_socket(description), socket_path(description)
    words = (*WORDS, *SWITCH_WORDS, *RELOAD_WORDS)
    return RecordStream(path, beside, lambda at: replace(first, at=at), words)


def header_of(description: Description, at: int) -> Header:
    """Return the header of a trace, with the origin of the trace."""
    return Header(
        at=at,
        run=token_hex(8),
        description=description.name,
        hash=content_hash(description),
        model=model_hash(description),
        version=product_version(),
        started=datetime.now(UTC).isoformat(),
        source=str(description.source),
        constants=model_constants(description),
    )


def model_hash(description: Description) -> str:
    """Return the first twelve hex digits of the hash of the UPPAAL file."""
    return hashlib.sha256(description.automata_path.read_bytes()).hexdigest()[:12]


def whole(description: Description) -> bytes:
    """Return the description as JSON, which is valid YAML, with all defaults written out.

    So a later version with other defaults reads the same description.
    """
    content = description.model_dump(mode="json", by_alias=True)
    content["automata"]["file"] = MODEL
    return json.dumps(content, indent=1, ensure_ascii=False).encode()
